#pragma once
/// Bilevel search: lengths on the upper level, masses on the lower one, with exact gradients.

#include "balance/synthesis/design/problem_functions.hpp"

namespace balance::design {

/// Promising designs, best first.
struct BilevelResult {
  bool is_applicable = false;     ///< conditions and figures are convex in the masses
  std::vector<VectorX> balanced;  ///< unit coordinates; residuals of the conditions are near round-off
  std::vector<VectorX> others;    ///< the best that are not balanced
};

/// Solves for the masses at space-filling points of the lengths. The best points start local searches:
/// Levenberg–Marquardt for the conditions, NLopt for the figure.
/// @param anchor unit coordinates at which the mechanism can be assembled
/// @param objective nullptr: no objective
/// @param ignore_conditions minimise the figure regardless of the conditions
BilevelResult search_bilevel(const SolverContext& context, const VectorX& anchor, const ScaledObjective* objective,
                             bool ignore_conditions);

}  // namespace balance::design
