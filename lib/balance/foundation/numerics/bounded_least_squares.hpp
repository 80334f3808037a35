#pragma once
/// Linear least squares with bounds.

#include "balance/foundation/base/types.hpp"

namespace balance::numerics {

/// Minimises |a x − b| subject to lower ≤ x ≤ upper by an active-set method that terminates in finitely many steps.
/// Source: Stark & Parker, Bounded-variable least squares, Computational Statistics 10 (1995).
/// @param a full column rank (ensured by appending a multiple of the identity)
/// @param x a feasible starting point; on return the solution, exactly on its active bounds
void bounded_least_squares(const MatrixX& a, const VectorX& b, const VectorX& lower, const VectorX& upper, VectorX& x);

}  // namespace balance::numerics
