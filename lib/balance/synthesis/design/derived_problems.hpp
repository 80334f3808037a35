#pragma once
/// Design problems derived from another one, for example with some variables fixed.

#include "balance/synthesis/design/design_problem.hpp"
#include "balance/synthesis/design/solver_context.hpp"

namespace balance::design {

// The design with the minimum violation of its limits, as a design problem without limits.

/// The same goals and variables, but the objective is the maximum violation of the limits, bounded below by a small
/// margin within all of them.
/// @param problem everything that it refers to must outlive the result
DesignProblem make_phase_one_problem(const DesignProblem& problem);

VectorX start_values(const DesignProblem& problem);

/// Replaces the start values by x, within the bounds.
void set_start(DesignProblem& problem, const VectorX& x);

/// Whether the bounds leave one value to every variable.
bool is_single_design(const DesignProblem& problem);

/// Value of a figure of the problem for values of the free numbers; NaN if undefined.
double evaluate_figure(const DesignProblem& problem, const Objective& figure, const VectorX& x);

/// Fixes lengths and ratios at x. The other variables are free and start from x. The conditions are then those of a
/// single geometry, and the objective is often convex.
/// @param seconds time limit
DesignProblem make_fixed_geometry_problem(const SolverContext& context, const VectorX& x, double seconds);

/// Indices of the variables that do not change the geometry, and of those that do.
std::vector<int> inertial_variables(const SolverContext& context);
std::vector<int> geometric_variables(const SolverContext& context);

}  // namespace balance::design
