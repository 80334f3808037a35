#pragma once
/// Lengths above, masses below: a search that follows exact rates of change.

#include "balance/synthesis/design/problem_functions.hpp"

namespace balance::design {

/// Designs worth a closer look, the best first.
struct BilevelResult {
  bool is_applicable = false;     ///< the problem is of the kind: conditions and figures are convex in the masses
  std::vector<VectorX> balanced;  ///< unit coordinates; what they leave of the conditions is near round-off
  std::vector<VectorX> others;    ///< the best of those that are not balanced
};

/// From points that fill the box of lengths: their best masses, then local searches from the best of them, Levenberg–Marquardt
/// for the conditions, NLopt's for the figure.
/// @param anchor unit coordinates with which the mechanism can be assembled
/// @param merit null: none
/// @param regardless the figure counts, not the conditions
BilevelResult search_bilevel(const SolverContext& context, const VectorX& anchor, const ScaledObjective* merit,
                             bool regardless);

}  // namespace balance::design
