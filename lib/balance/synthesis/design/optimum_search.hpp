#pragma once
/// The best of the exact solutions.

#include "balance/synthesis/design/convex_optimum.hpp"
#include "balance/synthesis/design/problem_functions.hpp"
#include "balance/synthesis/design/solver_context.hpp"

namespace balance::design {

// Least weighted sums of maxima of smooth functions: figures with known slopes, peaks among them.

/// Down from a point, within the box and with physical bodies. Every maximum gets a bound of its own, which is made small in its place
/// while all functions that it is taken over are kept below (epigraph form): at a minimum several peaks are often equal, and the sum has a
/// kink.
/// @param merit has pieces
/// @return the best admissible point that was met; nothing if `from` has no value
std::optional<VectorX> minimise_max_terms_from(const SolverContext& context, const ScaledObjective& merit,
                                               const VectorX& from);

/// From the best of some points that fill the box, and from `start`.
/// @return the ends, the best first; empty if there is no value anywhere
std::vector<VectorX> minimise_max_terms(const SolverContext& context, const ScaledObjective& merit,
                                        const VectorX& start);

/// Local searches from exact solutions, with the conditions as equalities or in their tangent space; at the end steps along every
/// tangent, so that no search ends at a bound from which a step back helps.
/// @param back brings a point near the conditions onto them
/// @param solutions at least one at which the figure has a value
Optimum optimise_exact_solutions(const SolverContext& context, const ScaledObjective& merit,
                                 const NonlinearSystem& equations, const std::function<VectorX(const VectorX&)>& back,
                                 const std::vector<VectorX>& solutions);

/// Global, then local search of the objective over all physical designs, met conditions or not.
/// @return value not finite: none was found at which it has a value
Optimum optimise_compromise(const SolverContext& context, const ScaledObjective& merit, const VectorX& start);

/// Global, then local search of the sum of squared residuals.
/// @param start the best known
/// @return physical, if the start values or the best known point are
VectorX minimise_residual(const SolverContext& context, const NonlinearSystem& equations,
                          const LeastSquaresResult& start, int evaluations);

}  // namespace balance::design
