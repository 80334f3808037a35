#pragma once
/// Other assembly modes in which a mechanism can make a motion that fails in its own.

#include "balance/mechanics/trajectory/motion_outcome.hpp"
#include "balance/mechanics/trajectory/trajectory.hpp"

#include <string>

namespace balance::simulation {

/// Text to append to the reason of a failure: "; another assembly mode can make this motion: assembly: {B: -1.2}".
/// Empty if the failure does not depend on the assembly mode, or there is only one.
/// @param trajectory whose run failed after its start
/// @throws std::invalid_argument as simulate()
std::string describe_feasible_modes(const Mechanism& mechanism, const Trajectory& trajectory,
                                    const MotionOutcome& outcome);

}  // namespace balance::simulation
