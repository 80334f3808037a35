#pragma once
/// Sentences about how runs end and what users should know of them, in the same words everywhere.

#include "balance/foundation/base/types.hpp"
#include "balance/mechanics/model/mechanism.hpp"
#include "balance/mechanics/model/topology.hpp"

#include <string>
#include <vector>

namespace balance {

/// A motion found: every joint coordinate over time.
enum class MotionStatus {
  unsolved,
  done,
  not_assembled,           ///< the loops cannot be closed at all
  unreachable,             ///< the loops close, but the prescribed start or end cannot be reached
  drive_singularity,       ///< the prescribed quantities no longer determine the motion
  constraint_singularity,  ///< the loop constraints lose rank: the mechanism gains a freedom
  actuation_singularity,   ///< the actuators no longer hold the mechanism
  assembly_jump,           ///< the motion could only go on in another assembly mode
  mismatch,                ///< drive or actuators do not match the degrees of freedom
  overflow,                ///< numbers became larger than can be computed with
  limits_not_held,         ///< no law of motion along the path keeps the stated limits
};

/// How a run ended; `reason` is one sentence for the user, with time and configuration where they matter.
struct MotionOutcome {
  MotionStatus status = MotionStatus::unsolved;
  double time = 0;  ///< where it stopped [s]
  std::string reason;
  std::vector<std::string> notes;  ///< what a user should know of a run that is done (minimum-norm actuation, …)
};

/// How a reason begins: "at t = 0.03 s: ".
std::string format_time_prefix(double time);

/// The end of a run whose actuators no longer hold the mechanism.
/// @param time [s]
/// @param configuration see format_configuration(); may be empty
MotionOutcome make_actuation_singularity_outcome(double time, const std::string& configuration);

enum class SingularityKind { motion, actuation };
/// @param mobility least there: smallest singular value of the matrix that becomes singular
std::string describe_near_singularity(SingularityKind what, double mobility, double time);

/// @param loop names of its joints @param times at which it loses rank on its own [s], not empty
std::string describe_change_point(const std::string& loop, const std::vector<double>& times);
/// @param actuator without which the others would not hold the mechanism
std::string describe_redundant_actuator(const std::string& actuator, const std::vector<double>& times);

/// The end of a run whose numbers grew too large to be computed with. @param time [s] @param what grew: "torque[A1]"
MotionOutcome make_overflow_outcome(double time, const std::string& what);
/// The same, or that the mechanism has no mass.
MotionOutcome make_overflow_outcome(double time, const std::string& what, const Mechanism& mechanism);

/// "the disc of L lies flat on its plane": where rates grow without bound; empty if none does.
/// @param coordinates all of the mechanism's
std::string describe_flat_disc(const Mechanism& mechanism, const std::vector<double>& coordinates);

std::string describe_under_actuation(int motors, int freedoms);
std::string describe_over_actuation(int motors, int freedoms);
std::string describe_over_constraint();
std::string describe_locked_freedom(const Mechanism& mechanism, const PassiveFreedom& spin);

}  // namespace balance
