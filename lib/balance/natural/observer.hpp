#pragma once
/// Everything that natural coordinates know of a moving mechanism at one moment. Private to natural and study.

#include "balance/natural/forces.hpp"
#include "balance/natural/stepper.hpp"

namespace balance::natural {

/// SI, world axes; moments about the observer's point.
struct Observation {
  std::vector<double> position, velocity, acceleration;  ///< per coordinate of the mechanism
  std::vector<double> effort, power;                     ///< per actuator
  Complex com, com_velocity, com_acceleration;
  Complex tool;
  double tool_angle = 0;
  Complex shaking_force;      ///< B M q̈ (P3 eq. 23)
  double shaking_moment = 0;  ///< q̃ M q̈ (P3 eq. 27)
  Complex ground_force;       ///< what the frame feels, weight included
  double ground_moment = 0;
  double kinetic_energy = 0, potential_energy = 0;
  /// What the shaking force and the weight are made of: Σ over the bodies' points of |M q̈| + |M g| [N].
  double force_scale = 0;
};

class Observer {
 public:
  /// @param model must outlive the observer
  Observer(const Mechanism& mechanism, const Model& model, int freedoms, const Vector3& about);

  /// Why the actuators do not fit the freedoms; empty if they do.
  const std::string& mismatch() const { return mismatch_; }
  const std::vector<std::string>& notes() const { return notes_; }

  /// @return false if the actuators do not hold the mechanism there
  bool observe(const Stepper& stepper);
  const Observation& last() const { return seen_; }
  /// Constraints and actuated coordinates together: has full rank where the actuators hold the mechanism.
  MatrixX held(const Equations& equations, const Coordinates& position) const;

 private:
  void read_coordinates(const Stepper& stepper);
  void read_momentum(const State& state);
  bool find_efforts(const Stepper& stepper);
  VectorX needed_forces(const Stepper& stepper);

  const Mechanism& mechanism_;
  const Model& model_;
  AppliedForces applied_;
  int freedoms_;
  Complex about_;
  Form com_, tool_;
  std::string mismatch_;
  std::vector<std::string> notes_;
  std::vector<Complex> inertia_;  ///< M q̈ per point
  Wrench loads_;
  Observation seen_;
};

}  // namespace balance::natural
