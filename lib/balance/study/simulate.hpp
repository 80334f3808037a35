#pragma once
/// One run along one trajectory.

#include "balance/model/mechanism.hpp"
#include "balance/motion/trajectory.hpp"
#include "balance/study/result.hpp"

namespace balance {

/// Moves the mechanism along the trajectory and computes everything of Result.
/// An unwelcome answer (unreachable, singular, …) is result.outcome, with the other fields empty.
/// @throws std::invalid_argument if trajectory and mechanism do not fit (a drive on the tool without a tool, …)
Result simulate(const Mechanism& mechanism, const Trajectory& trajectory);

}  // namespace balance
