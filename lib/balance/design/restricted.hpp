#pragma once
/// The same design problem with some of its numbers held. Private to design.

#include "balance/design/context.hpp"

namespace balance::design {

/// Lengths and ratios stay as they are at x, the other numbers are free and start from there: conditions of one geometry, and an
/// objective that often is convex.
/// @param seconds that it may take
DesignProblem make_fixed_geometry_problem(const SolverContext& context, const VectorX& x, double seconds);

/// Positions of the numbers that do not change the geometry, and of those that do.
std::vector<int> inertial_variables(const SolverContext& context);
std::vector<int> geometric_variables(const SolverContext& context);

}  // namespace balance::design
