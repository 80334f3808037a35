#pragma once
/// Nonlinear equations in the box by damped Gauss–Newton.

#include "balance/foundation/base/types.hpp"

#include <functional>

namespace balance::design {

/// Equations that are to vanish for −1 ≤ u ≤ 1.
struct NonlinearSystem {
  int primary_rows = 0;  ///< the first rows: scaled residuals of conditions
  int row_count = 0;     ///< the others vanish where the bodies are physical
  /// @param jacobian rows × numbers, or null
  /// @return false where the equations cannot be evaluated
  std::function<bool(const VectorX& u, VectorX& values, MatrixX* jacobian)> evaluate;
};

struct LeastSquaresResult {
  VectorX u;
  VectorX values;
  double max_residual = 0;  ///< of the values' sizes; infinite if the start cannot be evaluated
};

/// Levenberg–Marquardt with the bounds in every step's least-squares problem; ends at a solution to round-off or at a local
/// minimum of the sum of squares.
/// @param stop asked after the first twenty steps: true ends it; null: nothing does
LeastSquaresResult solve_levenberg_marquardt(const NonlinearSystem& equations, VectorX start, int iterations = 100,
                                             const std::function<bool()>& stop = {});

}  // namespace balance::design
