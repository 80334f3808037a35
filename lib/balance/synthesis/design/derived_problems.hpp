#pragma once
/// The same design problem with some of its numbers held.

#include "balance/synthesis/design/design_problem.hpp"
#include "balance/synthesis/design/solver_context.hpp"

namespace balance::design {

// The design that is least beyond its limits, as a design problem without them.

/// The same goals and numbers; to be made small is the largest violation of a limit, down to a little within all of them.
/// @param problem its functions must live as long as what is returned
DesignProblem make_phase_one_problem(const DesignProblem& problem);

/// A figure of a problem at values of the free numbers; NaN where it has none.
double evaluate_figure(const DesignProblem& problem, const Objective& figure, const VectorX& x);

/// Lengths and ratios stay as they are at x, the other numbers are free and start from there: conditions of one geometry, and an
/// objective that often is convex.
/// @param seconds that it may take
DesignProblem make_fixed_geometry_problem(const SolverContext& context, const VectorX& x, double seconds);

/// Positions of the numbers that do not change the geometry, and of those that do.
std::vector<int> inertial_variables(const SolverContext& context);
std::vector<int> geometric_variables(const SolverContext& context);

}  // namespace balance::design
