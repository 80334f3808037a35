#pragma once
/// Which other ways to assemble a mechanism can make a motion that it cannot make as it is.

#include "balance/mechanics/trajectory/motion_outcome.hpp"
#include "balance/mechanics/trajectory/trajectory.hpp"

#include <string>

namespace balance {

/// What to say of them after the reason of a failure: "; another assembly mode can make this motion: assembly: {B: -1.2}"; empty if the
/// failure is no matter of modes, or there is one mode only.
/// @param trajectory whose run has failed after its start
/// @throws std::invalid_argument as simulate()
std::string describe_feasible_modes(const Mechanism& mechanism, const Trajectory& trajectory,
                                    const MotionOutcome& outcome);

}  // namespace balance
