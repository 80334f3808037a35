#pragma once
/// Outcomes of runs and notes on them, in the same words everywhere.

#include "balance/foundation/base/types.hpp"
#include "balance/mechanics/model/mechanism.hpp"
#include "balance/mechanics/model/topology.hpp"

#include <string>
#include <vector>

namespace balance::trajectory {

/// How the computation of a motion ended.
enum class MotionStatus {
  unsolved,
  done,
  not_assembled,           ///< the loops cannot be closed at all
  unreachable,             ///< the loops close, but the prescribed start or end cannot be reached
  drive_singularity,       ///< the prescribed quantities no longer determine the motion
  constraint_singularity,  ///< the loop constraints lose rank: the mechanism gains a freedom
  actuation_singularity,   ///< the actuators no longer hold the mechanism
  assembly_jump,           ///< the motion could continue only in another assembly mode
  mismatch,                ///< drive or actuators do not match the degrees of freedom
  overflow,                ///< numbers overflow
  limits_not_held,         ///< no motion law along the path satisfies the limits
};

/// How a run ended. `reason` is one sentence for the user, with time and configuration if they matter.
struct MotionOutcome {
  MotionStatus status = MotionStatus::unsolved;
  double time = 0;  ///< where it ended [s]
  std::string reason;
  std::vector<std::string> notes;  ///< remarks on a completed run (minimum-norm actuation, …)
};

/// Prefix of a reason: "at t = 0.03 s: ".
std::string format_time_prefix(double time);

/// The end of a run whose actuators no longer hold the mechanism.
/// @param time [s]
/// @param configuration see format_configuration(); may be empty
MotionOutcome make_actuation_singularity_outcome(double time, const std::string& configuration);

enum class SingularityKind { motion, actuation };
/// @param mobility minimum there: smallest singular value of the matrix that becomes singular
std::string describe_near_singularity(SingularityKind what, double mobility, double time);

/// @param loop names of its joints @param times non-empty; when the loop alone loses rank [s]
std::string describe_change_point(const std::string& loop, const std::vector<double>& times);
/// @param actuator the actuator without which the others would not hold the mechanism
std::string describe_redundant_actuator(const std::string& actuator, const std::vector<double>& times);

/// The end of a run whose numbers overflow. @param time [s] @param what the quantity that overflows: "torque[A1]"
MotionOutcome make_overflow_outcome(double time, const std::string& what);
/// The same, but if the mechanism has no mass, reports that.
MotionOutcome make_overflow_outcome(double time, const std::string& what, const Mechanism& mechanism);

/// "the disc of L lies flat on its plane", where rates grow without bound; empty if no disc does.
/// @param coordinates all coordinates of the mechanism
std::string describe_flat_disc(const Mechanism& mechanism, const std::vector<double>& coordinates);

std::string describe_under_actuation(int motors, int freedoms);
/// @param distribution describe_distribution() of the mechanism's
std::string describe_over_actuation(int motors, int freedoms, const std::string& distribution);
/// A torque distribution has no effect.
std::string describe_determined_efforts(int motors, int freedoms);
/// Adds how efforts are distributed over redundant actuators, or that a distribution has no effect.
template <class T>
void add_distribution_note(const MechanismOf<T>& mechanism, int freedoms, std::vector<std::string>& notes) {
  const int motors = static_cast<int>(mechanism.actuators.size());
  if (motors > freedoms)
    notes.push_back(
        describe_over_actuation(motors, freedoms, model::describe_distribution(mechanism.torque_distribution)));
  else if (motors == freedoms && mechanism.torque_distribution)
    notes.push_back(describe_determined_efforts(motors, freedoms));
}
/// @param what that only linear efforts have: "parts"
std::string describe_nonlinear_efforts(const std::string& what);
std::string describe_over_constraint();
std::string describe_locked_freedom(const Mechanism& mechanism, const model::PassiveFreedom& spin);

}  // namespace balance::trajectory

namespace balance {

using trajectory::MotionOutcome;
using trajectory::MotionStatus;

}  // namespace balance
