#pragma once
/// Figures of runs along trajectories, for objectives and limits.

#include "balance/mechanics/results/result.hpp"
#include "balance/motion/study/design_space.hpp"

#include <string>
#include <vector>

namespace balance::simulation {

/// @throws std::invalid_argument if there is no trajectory of that name
const Trajectory& find_trajectory(const study::DesignInstance& instance, const ObjectiveTerm& term);

/// The figure of a run [SI]; NaN if the run is not done.
/// @param mechanism of the run; clearances are computed from it
/// @throws std::invalid_argument if the run does not have the quantity
double compute_run_figure(const Mechanism& mechanism, const RunResult& run, const ObjectiveTerm& term);

/// The same for a run that is simulated first.
double simulate_figure(const study::DesignInstance& instance, const ObjectiveTerm& term);

/// SI unit of a term without its weight; "1": a pure number.
std::string unit_of_term(const Mechanism& mechanism, const ObjectiveTerm& term);
/// SI unit of an objective: that of a single term without a weight; empty for sums.
std::string objective_unit(const std::vector<ObjectiveTerm>& terms, const Mechanism& mechanism);

/// Minimum distance during a completed run [m].
double min_clearance(const Mechanism& mechanism, const RunResult& run, const study::Clearance& clearance);

}  // namespace balance::simulation
