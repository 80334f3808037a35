#pragma once
/// Optimises the objective over the exact solutions, or over all admissible designs.

#include "balance/synthesis/design/convex_optimum.hpp"
#include "balance/synthesis/design/problem_functions.hpp"
#include "balance/synthesis/design/solver_context.hpp"

namespace balance::design {

// Minimisation of weighted sums of maxima of smooth functions: figures with known gradients, including peaks.

/// Descends from a point, within the box and with physical bodies. In epigraph form, each maximum is replaced by a
/// variable bound on all its functions, because several peaks are often equal at a minimum, where the sum has a kink.
/// @param objective must have max terms
/// @return the best admissible point visited; std::nullopt if there is none or `from` has no value
std::optional<VectorX> minimise_max_terms_from(const SolverContext& context, const ScaledObjective& objective,
                                               const VectorX& from);

/// Descends from `start` and from the best of some space-filling points.
/// @return the results, best first; empty if no point has a value
std::vector<VectorX> minimise_max_terms(const SolverContext& context, const ScaledObjective& objective,
                                        const VectorX& start);

/// Descends from an exact solution along gradients, with the conditions as equalities; the end may miss them slightly.
VectorX minimise_along_conditions(const SolverContext& context, const ScaledObjective& objective,
                                  const numerics::NonlinearSystem& equations, const VectorX& start);

/// Local searches from exact solutions, with the conditions as equalities or in their tangent space. Final steps along
/// all tangents ensure that no search ends at a bound from which a step back would help.
/// @param restore projects a point near the conditions onto them
/// @param solutions at least one, at which the figure has a value
Optimum optimise_exact_solutions(const SolverContext& context, const ScaledObjective& objective,
                                 const numerics::NonlinearSystem& equations,
                                 const std::function<VectorX(const VectorX&)>& restore,
                                 const std::vector<VectorX>& solutions);

/// A local search of the objective over all admissible designs, regardless of the conditions.
/// @return the start if nothing admissible was found
VectorX minimise_within_limits(const SolverContext& context, const ScaledObjective& objective, const VectorX& start);

/// Global, then local search of the objective over all admissible designs, regardless of the conditions.
/// @return value is not finite if no point with a value was found
Optimum optimise_compromise(const SolverContext& context, const ScaledObjective& objective, const VectorX& start);

/// Global, then local search for the minimum sum of squared residuals.
/// @param start best known point
/// @return admissible if the start values or the best known point are
VectorX minimise_residual(const SolverContext& context, const numerics::NonlinearSystem& equations,
                          const numerics::LeastSquaresResult& start, int evaluations);

}  // namespace balance::design
