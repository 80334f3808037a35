#pragma once
/// The least of the largest of several smooth functions within a convex set.

#include "balance/foundation/base/types.hpp"

#include <functional>
#include <vector>

namespace balance {

/// Functions of x, and a convex set around zero: {x : reach(x) ≤ 1}.
struct MinimaxProblem {
  /// The functions' values, positive; empty where there are none.
  std::function<VectorX(const VectorX& x)> values;
  /// Their derivatives, one row for each, at the x that values() was asked for last.
  std::function<MatrixX(const VectorX& x)> jacobian;
  /// By how much the set must grow to hold x.
  std::function<double(const VectorX& x)> gauge;
  /// Positive definite: what the curvature is taken for, but for a factor, before steps have shown it.
  MatrixX metric;
  /// Normals n of half-spaces n·x ≤ 1 that hold the set, but not x.
  std::function<std::vector<VectorX>(const VectorX& x)> cutting_planes;
};

struct MinimaxResult {
  VectorX x;
  double value = 0;  ///< the largest function's; infinite if there are none at the start
};

/// By sequential quadratic programming: in every step the functions are taken for linear, the curvature of their Lagrangian is what
/// the steps so far showed of it (Broyden, Fletcher, Goldfarb, Shanno, damped as Powell does), and the set for the half-spaces found
/// so far.
/// @param start within the set
MinimaxResult solve_minimax(const MinimaxProblem& problem, const VectorX& start);

}  // namespace balance
