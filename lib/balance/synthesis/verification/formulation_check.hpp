#pragma once
/// Compares both formulations for everything in a spec, and reports where they differ most.

#include "balance/motion/study/study.hpp"

#include "balance/mechanics/trajectory/motion_outcome.hpp"

#include <string>
#include <vector>

namespace balance::verification {

/// Differences up to this fraction of a quantity's scale are round-off: both formulations solve linear systems of a few
/// dozen unknowns to about 1e-13, and a path may come near a singularity.
inline constexpr double verify_tolerance = 1e-9;

struct QuantityDifference {
  std::string quantity;   ///< as in the result file; angles and slides separately: "joint_position (slides)"
  std::string unit;       ///< of difference and scale
  double difference = 0;  ///< maximum over samples and columns
  double time = 0;        ///< of the maximum [s]
  double scale = 0;  ///< largest magnitude of the quantity, but at least what its terms suggest (formulation_check.cpp)
  double relative() const { return scale > 0 ? difference / scale : difference; }
};

struct TrajectoryVerification {
  std::string trajectory;
  MotionOutcome tree, natural;
  std::vector<QuantityDifference> differences;  ///< empty unless both are done
  long samples = 0;
  double tolerance = verify_tolerance;  ///< larger if the path comes near a singularity (mobility below 0.02)
  bool is_consistent = false;           ///< within the tolerance, or both formulations fail
};

/// The force-balancing conditions, derived by sampling and from the coefficient matrices C_P.
struct ConditionsVerification {
  std::string reason;                 ///< why there is nothing to compare; empty if there is
  int sampled = 0, coefficients = 0;  ///< numbers of conditions
  double subspace_angle_sine = 0;  ///< sine of the largest angle between the spanned subspaces; 1 if the numbers differ
  bool is_consistent = false;
};

struct VerifyReport {
  std::vector<TrajectoryVerification> trajectories;
  ConditionsVerification conditions;
  bool is_consistent = false;
  /// Outcome of the first trajectory that both formulations refuse; done if there is none.
  MotionOutcome failed_outcome{MotionStatus::done, 0, "", {}};
};

/// @throws std::invalid_argument for a spatial mechanism, which has no second formulation
VerifyReport verify_formulations(const Study& study);

TrajectoryVerification verify_trajectory(const Mechanism& mechanism, const Trajectory& trajectory);
ConditionsVerification verify_conditions(const Study& study);

}  // namespace balance::verification

namespace balance {

using verification::verify_formulations;

}  // namespace balance
