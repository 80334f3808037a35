#pragma once
/// Linear least squares within bounds.

#include "balance/foundation/base/types.hpp"

namespace balance::design {

/// Minimises |a x − b| for lower ≤ x ≤ upper by an active set that ends after finitely many steps.
/// Source: Stark & Parker, Bounded-variable least squares, Computational Statistics 10 (1995).
/// @param a full column rank (a multiple of the identity below it provides for that)
/// @param x a feasible start; the solution, with bounds hit exactly
void bounded_least_squares(const MatrixX& a, const VectorX& b, const VectorX& lower, const VectorX& upper, VectorX& x);

}  // namespace balance::design
