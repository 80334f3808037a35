#pragma once
/// Linear programs with few unknowns and many inequalities, with their multipliers.

#include "balance/foundation/base/types.hpp"
#include "balance/foundation/numerics/linear_program.hpp"

namespace balance::numerics {

struct InequalityProgramSolution {
  LinearProgramStatus status = LinearProgramStatus::failed;
  VectorX x;            ///< rows may be violated by about 1e-10
  VectorX multipliers;  ///< one per row, not negative: rowsᵀ multipliers = gain
};

/// Maximise gain · x subject to rows · x ≤ limits. Solved as its dual, which has as few rows as there are unknowns.
/// Deterministic.
/// @return unbounded also if the dual is infeasible for another reason (no x meets the rows)
InequalityProgramSolution solve_inequality_program(const VectorX& gain, const MatrixX& rows, const VectorX& limits);

}  // namespace balance::numerics
