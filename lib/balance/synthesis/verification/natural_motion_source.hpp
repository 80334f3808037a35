#pragma once
/// The second formulation: a planar mechanism in natural coordinates (fully Cartesian coordinates), moved along a
/// trajectory. It shares with the first one only the Mechanism and the trajectory's values: it has basic points instead
/// of a tree, and a constant mass matrix and quadratic constraints instead of recursions.
/// Source: P3 sections 2 and 3, with its mass matrices re-derived; docs/theory.md, Natural coordinates.

#include "balance/mechanics/model/payload_intervals.hpp"
#include "balance/mechanics/trajectory/motion_source.hpp"
#include "balance/mechanics/trajectory/trajectory.hpp"
#include "balance/synthesis/verification/natural_dynamics.hpp"
#include "balance/synthesis/verification/natural_equations.hpp"

#include <cmath>
#include <optional>
#include <string>
#include <vector>

namespace balance::verification::natural {

/// A trajectory in a form that natural coordinates can follow.
struct NaturalCompiledTrajectory {
  MotionOutcome outcome;  ///< done if it can be followed
  int freedoms = 0;       ///< by rank
  trajectory::DriveQuantities quantities;
  NaturalCoordinates start;  ///< at time 0
  std::optional<trajectory::PrescribedMotion> prescribed_motion;
};

class NaturalMotionSource final : public trajectory::MotionSource {
 public:
  /// @param start a configuration near the trajectory's start; only its assembly mode and whole turns matter
  /// @throws std::invalid_argument if the mechanism is spatial, the start has the wrong size, or trajectory and
  /// mechanism do not match (a drive on the tool without a tool, …)
  NaturalMotionSource(const Mechanism& mechanism, const Trajectory& trajectory, const InitialCoordinates& start);

  const MotionOutcome& outcome() const override { return outcome_; }
  const trajectory::PrescribedMotion& prescribed_motion() const override { return plan_.prescribed_motion.value(); }
  bool begin() override;
  bool advance(double time) override { return check(stepper_->advance(time)); }
  void update_accelerations(trajectory::Side side) override { stepper_->accelerate(side); }
  bool update_payloads() override;
  double time() const override { return stepper_->time(); }
  bool evaluate() override;
  const Sample& sample() const override { return sample_; }
  double point_speed(BodyId body, const Vector3& point) const override;
  double angular_speed(BodyId body) const override { return std::abs(stepper_->angular_velocity(body)); }

  /// On the actuators.
  const std::vector<std::string>& notes() const { return evaluator_.value().notes(); }

 private:
  bool check(bool is_reached) {
    if (!is_reached) outcome_ = stepper_->outcome();
    return is_reached;
  }

  const Mechanism mechanism_;
  Mechanism current_mechanism_;  ///< with the payloads of the current interval
  NaturalModel model_;
  NaturalCompiledTrajectory plan_;
  Vector3 about_;
  std::optional<model::PayloadIntervals> intervals_;
  int interval_ = -1;  ///< whose payloads were applied last; −1: none yet
  std::optional<NaturalStepper> stepper_;
  std::optional<NaturalSampleEvaluator> evaluator_;
  Sample sample_;  ///< the last one; an evaluator ends with its interval
  MotionOutcome outcome_;
};

}  // namespace balance::verification::natural
