#pragma once
/// The mean square of a quantity that is linear in the unknowns: ∫ |F(t) x|² dt / T = |L x|². L has as many rows as
/// F(t) has independent directions.
///
/// L is computed by orthogonal transformations of the rows themselves. The normal equations FᵀF would be cheaper but
/// lose half of the digits: near balance the rms would be round-off.

#include "balance/foundation/base/types.hpp"
#include "balance/foundation/numerics/eigen_instantiations.hpp"

#include <vector>

namespace balance::design {

/// Sequential QR factorisation of weighted rows F(t).
class SequentialQr {
 public:
  explicit SequentialQr(Eigen::Index columns);

  /// @param rows k × columns
  /// @param weight in the average, not negative
  void add(const Eigen::Ref<const MatrixX>& rows, double weight);

  /// R, columns × columns upper triangular: Σ weight |F x|² = |R x|².
  MatrixX triangle();

 private:
  void reduce();

  MatrixX work_;  ///< the triangle so far, followed by rows not yet processed
  Eigen::Index filled_;
};

/// Units of the unknowns, needed to distinguish small columns from round-off.
struct ColumnScales {
  VectorX scale;                       ///< per column: SI value of its natural unit
  std::vector<Eigen::Index> families;  ///< first column of each family of similar columns, starting with 0
};

/// Coordinates z = L x of the relevant subspace: |z| is the root mean square, and F(t) x = G(t) z.
class RowSpace {
 public:
  RowSpace(const MatrixX& triangle, const ColumnScales& units);

  Eigen::Index rank() const { return coordinates_.rows(); }
  const std::vector<Eigen::Index>& active() const { return active_; }  ///< columns that are not zero
  const MatrixX& coordinates() const { return coordinates_; }          ///< L, rank × active
  /// @param rows F(t), k × columns
  /// @return G(t), k × rank
  MatrixX to_coordinates(const MatrixX& rows) const;

 private:
  std::vector<Eigen::Index> active_;
  std::vector<Eigen::Index> pivots_;  ///< `rank` independent columns
  MatrixX coordinates_;
  MatrixX pivot_block_;  ///< pivot columns of L, upper triangular
};

}  // namespace balance::design
