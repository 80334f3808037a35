#pragma once
/// Consistent systems with at least as many rows as columns, over any scalar, by QR with column pivoting. Over duals,
/// the values are factorised once and each derivative adds one right-hand side: if A x = b is consistent for all values
/// of the variables, so is A dx = db − dA x.

#include "balance/foundation/base/dual.hpp"
#include "balance/foundation/numerics/eigen_instantiations.hpp"

namespace balance::numerics {

// Regularity of a matrix with at least as many rows as columns, and whether it can lose rank along a path: the
// counterpart of BlockTriangular for square matrices.

/// Smallest pivot divided by the largest, 0 if there are fewer rows than columns.
double pivot_ratio(const ColumnPivotingQr& factors);

/// 1/|largest entry| of the pseudo-inverse, in the row of the least determined unknown: the counterpart of
/// BlockTriangular's measure for square matrices. At most 1; 0 if there are fewer rows than columns or the matrix is
/// singular.
double pseudo_inverse_regularity(const ColumnPivotingQr& factors);

/// Whether every matrix on the line segment from `stored` K to `current` A has full column rank by a margin:
/// ‖A⁺ (A − K)‖ ≤ limit < 1 (maximum row sum).
/// @param factors of `current`
bool is_near_stored(const ColumnPivotingQr& factors, const MatrixX& current, const MatrixX& stored, double limit);

/// For a matrix with at least as many rows as columns; 1 if it has no columns. Accurate to round-off of the largest
/// one.
double smallest_singular_value(const MatrixX& matrix);

/// Monitors a matrix along a path.
class RankMonitor {
 public:
  /// @return pseudo_inverse_regularity()
  double factorise(MatrixX matrix);
  /// Stores the matrix last factorised.
  void store() { stored_ = current_; }
  /// The function above for the matrices last stored and last factorised.
  bool is_near_stored(double limit) const { return numerics::is_near_stored(factors_, current_, stored_, limit); }
  /// Whether some matrix on the line segment from the stored one to the one last factorised, which has full column
  /// rank, is rank-deficient.
  bool loses_rank_since_stored() const;

 private:
  MatrixX current_, stored_;
  ColumnPivotingQr factors_;
};

template <class T>
class OverdeterminedSystem {
 public:
  void resize(int rows, int columns) { dense_.setZero(rows, columns); }
  T* storage() { return dense_.data(); }  ///< row-major
  const T* storage() const { return dense_.data(); }
  const T& at(int row, int column) const { return dense_(row, column); }
  const auto& dense() const { return dense_; }

  /// @return pseudo_inverse_regularity() of the values
  double factorise() {
    values_ = values();
    factors_.compute(values_);
    return pseudo_inverse_regularity(factors_);
  }
  void keep() { stored_ = values(); }
  bool near_kept(double limit) const { return numerics::is_near_stored(factors_, values_, stored_, limit); }

  /// In place: as many right-hand side entries as rows become as many unknowns as columns.
  void solve(T* x) const {
    const Eigen::Index rows = dense_.rows(), columns = dense_.cols();
    if constexpr (std::is_same_v<T, double>) {
      const VectorX solution = factors_.solve(Eigen::Map<const VectorX>(x, rows));
      for (Eigen::Index c = 0; c < columns; ++c) x[c] = solution[c];
    } else {
      VectorX rhs(rows);
      for (Eigen::Index r = 0; r < rows; ++r) rhs[r] = x[r].value;
      const VectorX solution = factors_.solve(rhs);
      MatrixX rhs_derivatives(rows, static_cast<Eigen::Index>(x[0].d.size()));
      for (Eigen::Index r = 0; r < rows; ++r)
        for (Eigen::Index k = 0; k < rhs_derivatives.cols(); ++k) {
          const auto variable = static_cast<std::size_t>(k);
          rhs_derivatives(r, k) = x[r].d[variable];
          for (Eigen::Index c = 0; c < columns; ++c) rhs_derivatives(r, k) -= dense_(r, c).d[variable] * solution[c];
        }
      const MatrixX derivatives = factors_.solve(rhs_derivatives);
      for (Eigen::Index c = 0; c < columns; ++c) {
        x[c].value = solution[c];
        for (Eigen::Index k = 0; k < rhs_derivatives.cols(); ++k)
          x[c].d[static_cast<std::size_t>(k)] = derivatives(c, k);
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
  MatrixX values_, stored_;
  ColumnPivotingQr factors_;
};

}  // namespace balance::numerics
