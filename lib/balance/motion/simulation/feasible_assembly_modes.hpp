#pragma once
/// In which assembly modes a mechanism can make a motion.

#include "balance/mechanics/trajectory/motion_outcome.hpp"
#include "balance/mechanics/trajectory/trajectory.hpp"

#include <string>
#include <vector>

namespace balance::simulation {

/// How a motion ends that begins in the mode with these coordinates, found by a run with two samples.
/// @param coordinates of all joints
/// @throws std::invalid_argument as simulate()
MotionOutcome find_outcome_in_mode(const Mechanism& mechanism, const Trajectory& trajectory,
                                   const std::vector<double>& coordinates);

/// Text to append to the reason of a failure: "; the end pose cannot be reached: …", or "; another assembly mode can
/// make this motion: assembly: {B: -1.2}". Empty if the failure depends on neither, or there is only one mode.
/// @param trajectory whose run failed after its start
/// @throws std::invalid_argument as simulate()
std::string describe_feasible_modes(const Mechanism& mechanism, const Trajectory& trajectory,
                                    const MotionOutcome& outcome);

}  // namespace balance::simulation
