#pragma once
/// The mean square of a quantity that is linear in unknowns: ∫ |F(t) x|² dt / T = |L x|², with as many rows in L as F(t) has
/// independent directions.
///
/// L is found by orthogonal transformations of the rows themselves. Their products, FᵀF, would cost less but lose half of the
/// digits: near balance the rms would be round-off.

#include "balance/foundation/base/types.hpp"
#include "balance/foundation/numerics/eigen_instantiations.hpp"

#include <vector>

namespace balance {

/// Rows F(t) with weights, reduced to a triangle as they come.
class SequentialQr {
 public:
  explicit SequentialQr(Eigen::Index columns);

  /// @param rows k × columns
  /// @param weight share of the average, not negative
  void add(const Eigen::Ref<const MatrixX>& rows, double weight);

  /// R, columns × columns upper triangular: Σ weight |F x|² = |R x|².
  MatrixX triangle();

 private:
  void reduce();

  MatrixX work_;  ///< the triangle so far, then rows not yet part of it
  Eigen::Index filled_;
};

/// Unknowns measured in common units, so that a small column can be told from round-off.
struct ColumnScales {
  VectorX scale;                       ///< per column: SI value of its natural unit
  std::vector<Eigen::Index> families;  ///< first column of every family of like columns, from 0
};

/// Coordinates z = L x of what matters: |z| is the root of the mean square, and F(t) x = G(t) z.
class RowSpace {
 public:
  RowSpace(const MatrixX& triangle, const ColumnScales& units);

  Eigen::Index rank() const { return coordinates_.rows(); }
  const std::vector<Eigen::Index>& active() const { return active_; }  ///< columns that occur
  const MatrixX& coordinates() const { return coordinates_; }          ///< L, rank × active
  /// @param rows F(t), k × columns
  /// @return G(t), k × rank
  MatrixX to_coordinates(const MatrixX& rows) const;

 private:
  std::vector<Eigen::Index> active_;
  std::vector<Eigen::Index> pivots_;  ///< independent columns, rank of them
  MatrixX coordinates_;
  MatrixX pivot_block_;  ///< columns of L at the pivots, upper triangular
};

}  // namespace balance
