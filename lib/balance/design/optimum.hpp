#pragma once
/// The best of the exact solutions. Private to design.

#include "balance/design/convex.hpp"

namespace balance::design {

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
