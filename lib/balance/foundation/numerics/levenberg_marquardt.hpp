#pragma once
/// Nonlinear equations with box bounds by damped Gauss–Newton.

#include "balance/foundation/base/types.hpp"

#include <functional>

namespace balance::numerics {

/// Equations to be solved for −1 ≤ u ≤ 1.
struct NonlinearSystem {
  int primary_rows = 0;  ///< number of leading rows: scaled residuals of conditions
  int row_count = 0;     ///< the remaining rows vanish if the bodies are physical
  /// @param jacobian rows × variables, or null
  /// @return false if the equations cannot be evaluated
  std::function<bool(const VectorX& u, VectorX& values, MatrixX* jacobian)> evaluate;
};

/// The equations as functions of some of the variables; the others have their values at u.
/// @param equations must outlive the result
NonlinearSystem restrict_to_variables(const NonlinearSystem& equations, const std::vector<int>& variables,
                                      const VectorX& u);

struct LeastSquaresResult {
  VectorX u;
  VectorX values;
  double max_residual = 0;  ///< maximum |value|; infinite if the start cannot be evaluated
};

/// Levenberg–Marquardt with the bounds as constraints of every step's least-squares problem. Ends at a solution to
/// round-off or at a local minimum of the sum of squares.
/// @param stop polled after the first twenty steps and ends the iteration by returning true; may be null
LeastSquaresResult solve_levenberg_marquardt(const NonlinearSystem& equations, VectorX start, int iterations = 100,
                                             const std::function<bool()>& stop = {});

}  // namespace balance::numerics
