#pragma once
/// The product of a nonnegative orthant and second-order cones: its Jordan algebra and its scaling. Private to design.
///
/// A vector has `linear` numbers first, then the blocks (t, v) with t ≥ |v|.
/// Source: Alizadeh & Goldfarb, Second-order cone programming, Mathematical Programming 95 (2003).

#include "balance/base/types.hpp"

#include <vector>

namespace balance::design {

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
  /// How many numbers a point's spectrum has, counted as the barrier does: one a block.
  Eigen::Index degree() const { return linear_ + static_cast<Eigen::Index>(blocks_.size()); }

  /// e with e ∘ x = x.
  VectorX identity() const;
  VectorX jordan_product(const VectorX& a, const VectorX& b) const;
  /// x with a ∘ x = b. @param a inside the cone
  VectorX jordan_quotient(const VectorX& a, const VectorX& b) const;
  /// The least eigenvalue: positive inside the cone.
  double min_eigenvalue(const VectorX& x) const;
  /// The largest step for which x + step · d stays in the cone; may be infinite. @param x inside
  double max_step(const VectorX& x, const VectorX& d) const;

 private:
  Eigen::Index linear_, size_;
  std::vector<Block> blocks_;
};

/// t² − |v|² of a block, without cancellation.
double cone_determinant(const VectorX& x, const SecondOrderCone::Block& block);

/// Nesterov–Todd: the symmetric W with W z = W⁻¹ s.
class NesterovToddScaling {
 public:
  /// @param s, z inside the cone, which must outlive the scaling
  NesterovToddScaling(const SecondOrderCone& cone, const VectorX& s, const VectorX& z);
  VectorX apply(const VectorX& v) const { return apply(v, false); }
  VectorX apply_inverse(const VectorX& v) const { return apply(v, true); }
  MatrixX scale_rows_inverse(MatrixX matrix) const;

 private:
  VectorX apply(VectorX v, bool inverse) const;

  const SecondOrderCone& cone_;
  VectorX diagonal_;    ///< of the linear part
  VectorX directions_;  ///< per block a point of determinant 1, in the cone's layout
  std::vector<double> lengths_;
};

}  // namespace balance::design
