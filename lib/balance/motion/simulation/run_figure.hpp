#pragma once
/// Figures of runs along trajectories, for objectives and limits.

#include "balance/mechanics/results/result.hpp"
#include "balance/motion/study/design_space.hpp"

namespace balance {

/// @throws std::invalid_argument if there is no trajectory of that name
const Trajectory& find_trajectory(const DesignInstance& instance, const ObjectiveTerm& term);

/// The figure of a run [SI]; NaN if the run is not done.
/// @param mechanism of the run; clearances are computed from it
/// @throws std::invalid_argument if the run does not have the quantity
double compute_run_figure(const Mechanism& mechanism, const RunResult& run, const ObjectiveTerm& term);

/// The same for a run that is simulated first.
double simulate_figure(const DesignInstance& instance, const ObjectiveTerm& term);

/// Minimum distance during a completed run [m].
double min_clearance(const Mechanism& mechanism, const RunResult& run, const Clearance& clearance);

}  // namespace balance
