#pragma once
/// Minimises the maximum of several smooth functions over a convex set.

#include "balance/foundation/base/types.hpp"

#include <functional>
#include <vector>

namespace balance::numerics {

/// Functions of x, and a convex set around zero: {x : gauge(x) ≤ 1}.
struct MinimaxProblem {
  /// The functions' values, positive; empty if they cannot be evaluated at x.
  std::function<VectorX(const VectorX& x)> values;
  /// Their derivatives, one row per function, at the x of the last call of values().
  std::function<MatrixX(const VectorX& x)> jacobian;
  /// Factor by which the set must be scaled to reach x.
  std::function<double(const VectorX& x)> gauge;
  /// Positive definite: the initial estimate of the curvature, up to a factor.
  MatrixX metric;
  /// Normals n of half-spaces n·x ≤ 1 that contain the set, but not x.
  std::function<std::vector<VectorX>(const VectorX& x)> cutting_planes;
};

struct MinimaxResult {
  VectorX x;
  double value = 0;  ///< maximum of the functions; infinite if they cannot be evaluated at the start
};

/// Sequential quadratic programming. Every step linearises the functions, approximates the Hessian of their Lagrangian
/// by BFGS updates with Powell's damping, and replaces the set by the half-spaces found so far.
/// @param start within the set
MinimaxResult solve_minimax(const MinimaxProblem& problem, const VectorX& start);

}  // namespace balance::numerics
