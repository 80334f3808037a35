#pragma once
/// Numbers that meet the conditions. Private to design.

#include "balance/design/equations.hpp"

namespace balance::designing {

/// A u = c with orthonormal rows, where the conditions are affine: independent and complete.
struct LinearConditions {
  MatrixX a;
  VectorX c;
};
LinearConditions linear_conditions(const Equations& equations, int numbers);

struct ExactSearch {
  std::vector<VectorX> solutions;  ///< distinct and physical; the one reached from the start values first
  Descent best;                    ///< smallest sum of squares where there is no solution
};

/// Gauss–Newton from the start values and from random points of the box.
/// @param wanted ends the search
ExactSearch find_exact(const Context& context, const Equations& equations, int restarts, int wanted);

/// Within bounds, met and physical.
bool is_exact(const Context& context, const Equations& equations, const VectorX& u);

/// Back onto the conditions from a point near them; to the last digit where `rows` give the residual of the mechanism itself.
/// @param rows of one geometry, or null
VectorX polished(const Equations& equations, const VectorX& u, const std::function<VectorX(const VectorX&)>& exact);

/// The solution nearest to the start values, in widths of the bounds, where conditions are affine and the physical designs
/// form a convex set; nothing if it is not found.
std::optional<VectorX> nearest_exact(const Context& context, const LinearConditions& conditions);

}  // namespace balance::designing
