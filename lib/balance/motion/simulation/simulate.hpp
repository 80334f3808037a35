#pragma once
/// One run along one trajectory.

#include "balance/mechanics/model/mechanism.hpp"
#include "balance/mechanics/results/result.hpp"
#include "balance/mechanics/trajectory/trajectory.hpp"

#include <functional>

namespace balance::simulation {

/// Called from time to time with the completed fraction of a run, from 0 to 1.
using Progress = std::function<void(double fraction)>;

/// Moves the mechanism along the trajectory and computes everything of RunResult.
/// Failures (unreachable, singular, …) are reported in result.outcome, with the other fields empty.
/// @throws std::invalid_argument if trajectory and mechanism do not match (a drive on the tool without a tool, …)
RunResult simulate(const Mechanism& mechanism, const Trajectory& trajectory, const Progress& progress = {});

}  // namespace balance::simulation

namespace balance {

using simulation::simulate;

}  // namespace balance
