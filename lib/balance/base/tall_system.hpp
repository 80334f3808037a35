#pragma once
/// Systems with at least as many rows as columns and a solution, over any scalar, by QR with column pivoting. Over duals the values are
/// factorised once, and per number there is one more right-hand side: where A x = b has a solution for all of the numbers' values,
/// A dx = db − dA x has one, too. Private to base, motion and dynamics.

#include "balance/base/dual.hpp"
#include "balance/base/tall_matrix.hpp"

namespace balance {

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
