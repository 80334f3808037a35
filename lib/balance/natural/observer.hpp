#pragma once
/// Finds what natural coordinates know of a moving mechanism at one moment. Private to natural and study.

#include "balance/motion/sample.hpp"
#include "balance/natural/forces.hpp"
#include "balance/natural/stepper.hpp"

namespace balance::natural {

class NaturalSampleEvaluator {
 public:
  /// @param model must outlive the observer
  NaturalSampleEvaluator(const Mechanism& mechanism, const NaturalModel& model, int freedoms, const Vector3& about);

  /// Why the actuators do not fit the freedoms; empty if they do.
  const std::string& mismatch() const { return mismatch_; }
  const std::vector<std::string>& notes() const { return notes_; }

  /// @return false if the actuators do not hold the mechanism there
  bool observe(const NaturalStepper& stepper);
  const Sample& last() const { return seen_; }
  /// Constraints and actuated coordinates together: has full rank where the actuators hold the mechanism.
  MatrixX actuation_matrix(const NaturalKinematicEquations& equations, const NaturalCoordinates& position) const;

 private:
  void read_coordinates(const NaturalStepper& stepper);
  void read_momentum(const NaturalState& state);
  bool solve_efforts(const NaturalStepper& stepper);
  VectorX needed_forces(const NaturalStepper& stepper);

  const Mechanism& mechanism_;
  const NaturalModel& model_;
  AppliedForces applied_;
  int freedoms_;
  Complex about_;
  AffineForm com_, tool_;
  std::string mismatch_;
  std::vector<std::string> notes_;
  std::vector<Complex> inertia_;  ///< M q̈ per point
  NaturalWrench loads_;
  Complex shaking_;  ///< Σ M q̈
  Vector3 point_;    ///< that moments are about
  Sample seen_;
};

}  // namespace balance::natural
