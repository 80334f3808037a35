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

/// Called when a start has ended.
/// @param u all variables; empty: the start ended without a design
/// @param is_balanced whether the residuals of the conditions are near round-off
/// @return true if the search shall start no more
using StartEndHandler = std::function<bool(const VectorX& u, bool is_balanced)>;

/// Solves for the masses at the anchor and at space-filling points of the lengths. The anchor and the best of these
/// points start local searches: Levenberg–Marquardt for the conditions, NLopt for the figure.
/// @param anchor unit coordinates at which the mechanism can be assembled
/// @param objective nullptr: no objective
/// @param ignore_conditions minimise the figure regardless of the conditions
/// @param handle_start_end of searches for the figure; may be null
BilevelResult search_bilevel(const SolverContext& context, const VectorX& anchor, const ScaledObjective* objective,
                             bool ignore_conditions, const StartEndHandler& handle_start_end = {});

}  // namespace balance::design
