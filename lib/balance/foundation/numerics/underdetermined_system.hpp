#pragma once
/// Solutions of A x = b with fewer equations than unknowns, the smallest within bounds.

#include "balance/foundation/base/types.hpp"

#include <vector>

namespace balance::numerics {

/// Norm by which a solution is the smallest.
enum class SolutionNorm {
  euclidean,
  maximum,  ///< of all solutions with the same largest magnitude, the one of least Euclidean norm
};

struct UnderdeterminedSystem {
  MatrixX matrix;                         ///< full row rank
  VectorX right_hand_side, lower, upper;  ///< bounds may be infinite; lower ≤ upper
  VectorX excess_scale;                   ///< > 0, see BoundedSolution::excess
};

/// An equation x[index] = bound of the solution.
struct ActiveBound {
  enum class Kind {
    lower,        ///< lower − excess · excess_scale
    upper,        ///< upper + excess · excess_scale
    lowest_peak,  ///< −peak
    highest_peak  ///< peak
  };
  Eigen::Index index = 0;
  Kind kind = Kind::lower;
};

struct BoundedSolution {
  VectorX x;
  double excess =
      0;  ///< least number e for which some solution is within lower − e excess_scale, upper + e excess_scale
  double peak = 0;  ///< maximum norm: the largest magnitude
  /// The bounds that determine x: it is the solution of least Euclidean norm that meets them, and excess and peak are
  /// the numbers with which there is one. Some may follow from the others.
  std::vector<ActiveBound> active;
};

/// Deterministic, and a continuous function of the right-hand side and the bounds. As a function of the matrix it may
/// jump with the maximum norm, where a component that alone has the largest magnitude leaves the null space.
/// Sources: Goldfarb & Idnani (quadratic_program.hpp); Rockafellar, Monotone operators and the proximal point algorithm,
/// SIAM J. Control Optim. 14 (1976), which for linear programs ends after finitely many steps.
BoundedSolution solve_bounded(const UnderdeterminedSystem& system, SolutionNorm norm);

}  // namespace balance::numerics
