#pragma once
/// Linear programs of a few hundred unknowns. The only place that knows Clp.

#include "balance/foundation/base/types.hpp"

#include <limits>

namespace balance {

inline constexpr double no_bound = std::numeric_limits<double>::infinity();

/// Minimise cost · x subject to lower ≤ x ≤ upper and row_lower ≤ rows · x ≤ row_upper; `no_bound` and its negative where
/// there is no limit.
struct LinearProgram {
  VectorX cost, lower, upper;
  MatrixX rows;
  VectorX row_lower, row_upper;

  /// n unknowns without limits, no cost, no rows.
  explicit LinearProgram(Eigen::Index n);
  /// Room is made by doubling, so that rows may be added one by one.
  void add_row(double low, const VectorX& row, double high);
  Eigen::Index row_count() const { return used_; }

 private:
  Eigen::Index used_ = 0;
};

enum class LinearProgramStatus {
  optimal,
  infeasible,
  unbounded,  ///< the cost falls without limit
  failed,
};

struct LinearProgramSolution {
  LinearProgramStatus status = LinearProgramStatus::failed;
  VectorX x;  ///< limits may be overstepped by about 1e-10
};

/// The same program gives the same solution.
LinearProgramSolution solve_linear_program(const LinearProgram& program);

}  // namespace balance
