#pragma once
/// Time-optimal law along a path by two passes over a grid, for cases in which phase-plane integration fails.

#include "balance/motion/time_optimal/time_optimal_law.hpp"

#include <vector>

namespace balance::time_optimal {

/// Solves one leg. In every cell s'' is linear in s and the limits hold at both ends. Cells are halved until the limits
/// also hold between the nodes and one of them is active nearly everywhere.
/// @param bounds one per row of the model
/// @return nodes from the beginning to the end of the leg, t from zero; or a reason for infeasibility
TimeOptimalLaw solve_by_reachability(const PathModel& model, const std::vector<double>& bounds, const SegmentRange& leg,
                                     const EndpointRates& rates);

}  // namespace balance::time_optimal
