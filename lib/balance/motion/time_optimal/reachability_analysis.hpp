#pragma once
/// The fastest way along a path by two sweeps over a grid: where arcs lose their way.

#include "balance/motion/time_optimal/time_optimal_law.hpp"

#include <vector>

namespace balance {

/// One leg of it, by cells in which s'' is linear in s and the limits hold at both ends; cells are halved until limits are kept
/// between the nodes, too, and one of them is reached nearly everywhere.
/// @param bounds one per row of the model
/// @return nodes from the leg's begin to its end, t from zero; or a refusal
TimeOptimalLaw solve_by_reachability(const PathModel& model, const std::vector<double>& bounds, const SegmentRange& leg,
                                     const EndpointRates& rates);

}  // namespace balance
