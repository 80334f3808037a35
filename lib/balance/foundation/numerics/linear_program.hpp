#pragma once
/// Linear programs of a few hundred unknowns. Only this module uses Clp.

#include "balance/foundation/base/types.hpp"

#include <limits>

namespace balance::numerics {

inline constexpr double no_bound = std::numeric_limits<double>::infinity();

/// Minimise cost · x subject to lower ≤ x ≤ upper and row_lower ≤ rows · x ≤ row_upper; `no_bound` and its negative
/// stand for missing bounds.
struct LinearProgram {
  VectorX cost, lower, upper;
  MatrixX rows;
  VectorX row_lower, row_upper;

  /// n unknowns without bounds, no cost, no rows.
  explicit LinearProgram(Eigen::Index n);
  /// Doubles the storage when it is full, so that rows may be added one by one.
  void add_row(double low, const VectorX& row, double high);
  Eigen::Index row_count() const { return row_count_; }

 private:
  Eigen::Index row_count_ = 0;
};

enum class LinearProgramStatus {
  optimal,
  infeasible,
  unbounded,  ///< the cost is not bounded below
  failed,
};

struct LinearProgramSolution {
  LinearProgramStatus status = LinearProgramStatus::failed;
  VectorX x;  ///< bounds may be violated by about 1e-10
};

/// Deterministic: the same program gives the same solution.
LinearProgramSolution solve_linear_program(const LinearProgram& program);

}  // namespace balance::numerics
