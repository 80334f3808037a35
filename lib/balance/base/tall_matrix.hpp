#pragma once
/// How regular a matrix with at least as many rows as columns is, and whether it can have lost rank on a way: what
/// BlockTriangular says of square ones. Private to base, motion, dynamics and natural.

#include "balance/base/factorizations.hpp"

namespace balance {

/// Smallest pivot by the largest, 0 if there are fewer rows than columns.
double pivot_ratio(const ColumnPivotingQr& factors);

/// 1/largest entry of the pseudo-inverse, the measure that BlockTriangular has of square matrices, of the unknown that is determined
/// least; at most 1, 0 if there are fewer rows than columns or the matrix is singular.
double pseudo_inverse_regularity(const ColumnPivotingQr& factors);

/// Whether every matrix on the straight way from `kept` to `now` has full column rank by a margin: ‖A⁺ (A − K)‖ ≤ limit < 1 (largest
/// sum along a row).
/// @param factors of `now`
bool is_near_stored(const ColumnPivotingQr& factors, const MatrixX& now, const MatrixX& kept, double limit);

/// Of a matrix with at least as many rows as columns; 1 if it has none. Good to round-off of the largest one.
double smallest_singular_value(const MatrixX& matrix);

/// A matrix that is looked at again and again along a way.
class RankMonitor {
 public:
  /// @return smallest pivot by the largest
  double factorise(MatrixX matrix);
  /// Remembers the matrix last looked at.
  void store() { kept_ = now_; }
  /// As the function above, of the matrices kept and last looked at.
  bool is_near_stored(double limit) const { return balance::is_near_stored(factors_, now_, kept_, limit); }
  /// Whether some matrix on the straight way from the one kept to the one last looked at, which has full column rank, has not.
  bool loses_rank_since_stored() const;

 private:
  MatrixX now_, kept_;
  ColumnPivotingQr factors_;
};

}  // namespace balance
