#pragma once
/// Lengths above, masses below: a search that follows exact rates of change. Private to design.

#include "balance/design/figure_of_merit.hpp"

namespace balance::designing {

/// Designs worth a closer look, the best first.
struct TwoLevelDesigns {
  bool able = false;              ///< the problem is of the kind: conditions and figures are convex in the masses
  std::vector<VectorX> balanced;  ///< unit coordinates; what they leave of the conditions is near round-off
  std::vector<VectorX> others;    ///< the best of those that are not balanced
};

/// From points that fill the box of lengths: their best masses, then local searches from the best of them, Levenberg–Marquardt
/// for the conditions, NLopt's for the figure.
/// @param anchor unit coordinates with which the mechanism can be assembled
/// @param merit null: none
/// @param regardless the figure counts, not the conditions
TwoLevelDesigns search_two_levels(const Context& context, const VectorX& anchor, const FigureOfMerit* merit,
                                  bool regardless);

}  // namespace balance::designing
