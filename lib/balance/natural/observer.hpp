#pragma once
/// Finds what natural coordinates know of a moving mechanism at one moment. Private to natural and study.

#include "balance/motion/sample.hpp"
#include "balance/natural/forces.hpp"
#include "balance/natural/stepper.hpp"

namespace balance::natural {

class Observer {
 public:
  /// @param model must outlive the observer
  Observer(const Mechanism& mechanism, const Model& model, int freedoms, const Vector3& about);

  /// Why the actuators do not fit the freedoms; empty if they do.
  const std::string& mismatch() const { return mismatch_; }
  const std::vector<std::string>& notes() const { return notes_; }

  /// @return false if the actuators do not hold the mechanism there
  bool observe(const Stepper& stepper);
  const Sample& last() const { return seen_; }
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
  Complex shaking_;  ///< Σ M q̈
  Vector3 point_;    ///< that moments are about
  Sample seen_;
};

}  // namespace balance::natural
