#include "balance/control/column_choice.hpp"

#include "balance/base/extrema.hpp"
#include "balance/base/factorizations.hpp"

#include <algorithm>
#include <cmath>

namespace balance {

namespace {

constexpr double moving_pivot_tolerance =
    1e-5;  // smallest pivot, against the largest, that columns which move must leave to determine others

}  // namespace

double compute_reciprocal_condition(const MatrixX& matrix) {
  if (matrix.size() == 0) return 1;
  const VectorX values = singular_values(matrix);
  return values[0] > 0 ? values[values.size() - 1] / values[0] : 0;
}

MatrixX select_columns(const MatrixX& matrix, const std::vector<int>& columns) {
  MatrixX out(matrix.rows(), static_cast<Eigen::Index>(columns.size()));
  for (std::size_t k = 0; k < columns.size(); ++k) out.col(static_cast<Eigen::Index>(k)) = matrix.col(columns[k]);
  return out;
}

std::vector<int> complement_indices(const std::vector<int>& some, int n) {
  std::vector<int> out;
  for (int c = 0; c < n; ++c)
    if (std::find(some.begin(), some.end(), c) == some.end()) out.push_back(c);
  return out;
}

/// The first `count` pivots of a QR decomposition with column pivoting.
std::vector<int> pivot_columns(const MatrixX& matrix, int count, double& last) {
  const ColumnPivotingQr qr(matrix);
  std::vector<int> out;
  last = 1;
  for (int k = 0; k < count; ++k) {
    out.push_back(qr.colsPermutation().indices()[k]);
    last = std::abs(qr.matrixQR()(k, k) / qr.matrixQR()(0, 0));
  }
  if (!(last == last)) last = 0;
  std::sort(out.begin(), out.end());
  return out;
}

std::vector<int> pivot_moving_columns(const MatrixX& matrix, int count, const std::vector<bool>& stuck) {
  std::vector<int> moving, standing, out;
  for (int c = 0; c < static_cast<int>(matrix.cols()); ++c)
    (stuck[static_cast<std::size_t>(c)] ? standing : moving).push_back(c);
  MatrixX rest = select_columns(matrix, standing);
  const double largest = max_abs(matrix.colwise().norm());
  int found = 0;
  if (!moving.empty()) {
    const ColumnPivotingQr qr(select_columns(matrix, moving));
    const auto most = static_cast<int>(std::min(qr.matrixQR().rows(), qr.matrixQR().cols()));
    for (; found < std::min(count, most) && std::abs(qr.matrixQR()(found, found)) > moving_pivot_tolerance * largest;
         ++found)
      out.push_back(moving[static_cast<std::size_t>(qr.colsPermutation().indices()[found])]);
    rest.applyOnTheLeft(qr.householderQ().adjoint());
  }
  if (found < count && !standing.empty()) {
    const MatrixX left = rest.bottomRows(rest.rows() - found);
    double last;
    for (const int c : pivot_columns(left, count - found, last)) out.push_back(standing[static_cast<std::size_t>(c)]);
  }
  std::sort(out.begin(), out.end());
  return out;
}

}  // namespace balance
