#pragma once
/// What a run along a trajectory comes to, for objectives and limits.

#include "balance/mechanics/results/result.hpp"
#include "balance/motion/study/design_space.hpp"

namespace balance {

/// @throws std::invalid_argument if there is none of that name
const Trajectory& find_trajectory(const DesignInstance& trial, const ObjectiveTerm& term);

/// The term's number of a run [SI]. NaN if the motion was not made.
/// @param mechanism whose places a clearance is between; it makes the run's motion
/// @throws std::invalid_argument if the run does not have the quantity
double compute_run_figure(const Mechanism& mechanism, const RunResult& run, const ObjectiveTerm& term);

/// The same of a run to be made.
double simulate_figure(const DesignInstance& trial, const ObjectiveTerm& term);

/// The least distance in a run that is done [m].
double min_clearance(const Mechanism& mechanism, const RunResult& run, const Clearance& clearance);

}  // namespace balance
