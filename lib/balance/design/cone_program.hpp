#pragma once
/// Linear objectives over linear inequalities and second-order cones. Private to design.

#include "balance/design/second_order_cone.hpp"

namespace balance::design {

/// Minimise cost · x subject to slack = right − matrix x in the cone.
struct ConeProgram {
  VectorX cost;
  MatrixX matrix;  ///< full column rank
  VectorX rhs;
  Eigen::Index linear_rows = 0;          ///< leading rows that are inequalities
  std::vector<Eigen::Index> cone_sizes;  ///< sizes of the blocks (t, v), t ≥ |v|, behind them
};

/// Appends rows to a cone program; linear ones first.
class ConeProgramBuilder {
 public:
  explicit ConeProgramBuilder(Eigen::Index variables) : variables_(variables) {}
  /// coefficients · x ≤ limit
  void add_inequalities(const Eigen::Ref<const VectorX>& coefficients, double limit);
  /// rows x ≤ limits
  void add_inequalities(const Eigen::Ref<const MatrixX>& rows, const Eigen::Ref<const VectorX>& limits);
  /// (t, v) = constant + rows x with t ≥ |v|
  void add_cone(const Eigen::Ref<const MatrixX>& rows, const Eigen::Ref<const VectorX>& constant);
  /// Rows so far.
  Eigen::Index linear_row_count() const { return count_linear_; }
  Eigen::Index conic_row_count() const { return count_conic_; }
  ConeProgram build(VectorX cost) const;

 private:
  Eigen::Index variables_, count_linear_ = 0, count_conic_ = 0;
  std::vector<std::pair<MatrixX, VectorX>> linear_, cones_;
};

/// The program with more inequalities, matrix x ≤ right.
ConeProgram add_inequalities(const ConeProgram& program, const MatrixX& matrix, const VectorX& right);

enum class ConeStatus { failed, optimal };

struct ConeSolution {
  ConeStatus status = ConeStatus::failed;  ///< unsolved: infeasible, unbounded or numerically out of reach
  VectorX x;
  VectorX slack, multipliers;  ///< both in the cone, orthogonal; matrixᵀ multipliers = −cost
  double primal_value = 0;     ///< cost · x
  double dual_value = 0;       ///< −right · multipliers: no feasible x is below it
  int iterations = 0;
};

/// Primal-dual interior-point method with Mehrotra's corrector and Nesterov–Todd scaling; its linear systems are least-squares
/// problems solved by orthogonal factors, so that the last digits are kept.
/// @param tolerance of residuals and gap, relative
/// Source: Vandenberghe, The CVXOPT linear and quadratic cone program solvers (2010).
ConeSolution solve_cone_program(const ConeProgram& program, double tolerance = 1e-11);

}  // namespace balance::design
