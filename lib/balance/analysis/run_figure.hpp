#pragma once
/// What a run along a trajectory comes to, for objectives and limits.

#include "balance/result/result.hpp"
#include "balance/study/design_space.hpp"

namespace balance {

/// @throws std::invalid_argument if there is none of that name
const Trajectory& trajectory_of(const Trial& trial, const ObjectiveTerm& term);

/// The term's number of a run [SI]. NaN if the motion was not made.
/// @param mechanism whose places a clearance is between; it makes the run's motion
/// @throws std::invalid_argument if the run does not have the quantity
double run_figure(const Mechanism& mechanism, const Result& run, const ObjectiveTerm& term);

/// The same of a run to be made.
double by_simulation(const Trial& trial, const ObjectiveTerm& term);

/// The least distance in a run that is done [m].
double least_clearance(const Mechanism& mechanism, const Result& run, const Clearance& clearance);

}  // namespace balance
