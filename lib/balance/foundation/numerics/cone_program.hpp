#pragma once
/// Linear objectives subject to linear inequalities and second-order cone constraints.

#include "balance/foundation/base/types.hpp"

#include <vector>

namespace balance::numerics {

/// The product of a nonnegative orthant and second-order cones, with its Jordan algebra. A vector holds `linear`
/// numbers, then the blocks (t, v); inside the cone t ≥ |v|.
/// Source: Alizadeh & Goldfarb, Second-order cone programming, Mathematical Programming 95 (2003).
class SecondOrderCone {
 public:
  /// @param sizes of the blocks, each at least 1
  SecondOrderCone(Eigen::Index linear, const std::vector<Eigen::Index>& sizes);

  struct Block {
    Eigen::Index first, size;
  };
  Eigen::Index linear() const { return linear_; }
  const std::vector<Block>& blocks() const { return blocks_; }
  Eigen::Index size() const { return size_; }
  /// Degree of the barrier: one per linear entry and one per block.
  Eigen::Index degree() const { return linear_ + static_cast<Eigen::Index>(blocks_.size()); }

  /// e with e ∘ x = x.
  VectorX identity() const;
  VectorX jordan_product(const VectorX& a, const VectorX& b) const;
  /// x with a ∘ x = b. @param a inside the cone
  VectorX jordan_quotient(const VectorX& a, const VectorX& b) const;
  /// The smallest eigenvalue: positive inside the cone.
  double min_eigenvalue(const VectorX& x) const;
  /// The largest step for which x + step · d stays in the cone; may be infinite. @param x inside the cone
  double max_step(const VectorX& x, const VectorX& d) const;

 private:
  Eigen::Index linear_, size_;
  std::vector<Block> blocks_;
};

/// t² − |v|² of a block, without cancellation.
double cone_determinant(const VectorX& x, const SecondOrderCone::Block& block);

/// Nesterov–Todd scaling: the symmetric W with W z = W⁻¹ s.
class NesterovToddScaling {
 public:
  /// @param cone must outlive the scaling
  /// @param s, z inside the cone
  NesterovToddScaling(const SecondOrderCone& cone, const VectorX& s, const VectorX& z);
  VectorX apply(const VectorX& v) const { return apply(v, false); }
  VectorX apply_inverse(const VectorX& v) const { return apply(v, true); }
  MatrixX scale_rows_inverse(MatrixX matrix) const;

 private:
  VectorX apply(VectorX v, bool inverse) const;

  const SecondOrderCone& cone_;
  VectorX diagonal_;    ///< of the linear part
  VectorX directions_;  ///< per block, a point of determinant 1, in the cone's layout
  std::vector<double> lengths_;
};

/// Minimise cost · x subject to slack = rhs − matrix x in the cone.
struct ConeProgram {
  VectorX cost;
  MatrixX matrix;  ///< full column rank
  VectorX rhs;
  Eigen::Index linear_rows = 0;          ///< number of leading rows that are inequalities
  std::vector<Eigen::Index> cone_sizes;  ///< sizes of the blocks (t, v), t ≥ |v|, that follow
};

/// Assembles a cone program from rows; build() puts the linear ones first.
class ConeProgramBuilder {
 public:
  explicit ConeProgramBuilder(Eigen::Index variables) : variables_(variables) {}
  /// coefficients · x ≤ limit
  void add_inequalities(const Eigen::Ref<const VectorX>& coefficients, double limit);
  /// rows x ≤ limits
  void add_inequalities(const Eigen::Ref<const MatrixX>& rows, const Eigen::Ref<const VectorX>& limits);
  /// (t, v) = constant + rows x with t ≥ |v|
  void add_cone(const Eigen::Ref<const MatrixX>& rows, const Eigen::Ref<const VectorX>& constant);
  /// Number of rows so far.
  Eigen::Index linear_row_count() const { return count_linear_; }
  Eigen::Index conic_row_count() const { return count_conic_; }
  ConeProgram build(VectorX cost) const;

 private:
  Eigen::Index variables_, count_linear_ = 0, count_conic_ = 0;
  std::vector<std::pair<MatrixX, VectorX>> linear_, cones_;
};

/// Adds the inequalities matrix x ≤ rhs to a program.
ConeProgram add_inequalities(const ConeProgram& program, const MatrixX& matrix, const VectorX& rhs);

enum class ConeStatus { failed, optimal };

struct ConeSolution {
  ConeStatus status = ConeStatus::failed;  ///< failed: infeasible, unbounded or numerically intractable
  VectorX x;
  VectorX slack, multipliers;  ///< both in the cone, orthogonal; matrixᵀ multipliers = −cost
  double primal_value = 0;     ///< cost · x
  double dual_value = 0;       ///< −rhs · multipliers: a lower bound on cost · x of every feasible x
  int iterations = 0;
};

/// Primal-dual interior-point method with Mehrotra's corrector and Nesterov–Todd scaling. Its linear systems are solved
/// as least-squares problems by QR, which preserves the last digits.
/// @param tolerance of residuals and gap, relative
/// Source: Vandenberghe, The CVXOPT linear and quadratic cone program solvers (2010).
ConeSolution solve_cone_program(const ConeProgram& program, double tolerance = 1e-11);

}  // namespace balance::numerics
