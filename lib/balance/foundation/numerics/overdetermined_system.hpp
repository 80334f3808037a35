#pragma once
/// Systems with at least as many rows as columns and a solution, over any scalar, by QR with column pivoting. Over duals the values are
/// factorised once, and per number there is one more right-hand side: where A x = b has a solution for all of the numbers' values,
/// A dx = db − dA x has one, too.

#include "balance/foundation/base/dual.hpp"
#include "balance/foundation/numerics/eigen_instantiations.hpp"

namespace balance {

// How regular a matrix with at least as many rows as columns is, and whether it can have lost rank on a way: what
// BlockTriangular says of square ones.

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

template <class T>
class OverdeterminedSystem {
 public:
  void resize(int rows, int columns) { dense_.setZero(rows, columns); }
  T* storage() { return dense_.data(); }  ///< row by row
  const T* storage() const { return dense_.data(); }
  const T& at(int row, int column) const { return dense_(row, column); }
  const auto& dense() const { return dense_; }

  /// @return regularity of the values
  double factorise() {
    values_ = values();
    factors_.compute(values_);
    return pseudo_inverse_regularity(factors_);
  }
  void keep() { kept_ = values(); }
  bool near_kept(double limit) const { return balance::is_near_stored(factors_, values_, kept_, limit); }

  /// As many right-hand sides as rows into as many unknowns as columns, in place.
  void solve(T* x) const {
    const Eigen::Index rows = dense_.rows(), columns = dense_.cols();
    if constexpr (std::is_same_v<T, double>) {
      const VectorX solution = factors_.solve(Eigen::Map<const VectorX>(x, rows));
      for (Eigen::Index c = 0; c < columns; ++c) x[c] = solution[c];
    } else {
      VectorX side(rows);
      for (Eigen::Index r = 0; r < rows; ++r) side[r] = x[r].value;
      const VectorX solution = factors_.solve(side);
      MatrixX sides(rows, static_cast<Eigen::Index>(x[0].d.size()));
      for (Eigen::Index r = 0; r < rows; ++r)
        for (Eigen::Index k = 0; k < sides.cols(); ++k) {
          const auto number = static_cast<std::size_t>(k);
          sides(r, k) = x[r].d[number];
          for (Eigen::Index c = 0; c < columns; ++c) sides(r, k) -= dense_(r, c).d[number] * solution[c];
        }
      const MatrixX derivatives = factors_.solve(sides);
      for (Eigen::Index c = 0; c < columns; ++c) {
        x[c].value = solution[c];
        for (Eigen::Index k = 0; k < sides.cols(); ++k) x[c].d[static_cast<std::size_t>(k)] = derivatives(c, k);
      }
    }
  }

 private:
  MatrixX values() const {
    if constexpr (std::is_same_v<T, double>)
      return dense_;
    else
      return dense_.unaryExpr([](const T& x) { return x.value; });
  }

  Eigen::Matrix<T, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> dense_;
  MatrixX values_, kept_;
  ColumnPivotingQr factors_;
};

}  // namespace balance
