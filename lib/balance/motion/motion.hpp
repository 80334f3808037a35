#pragma once
/// A motion found: every joint coordinate over time.

#include "balance/base/types.hpp"

#include <string>
#include <vector>

namespace balance {

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

}  // namespace balance
