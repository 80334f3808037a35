#include "balance/foundation/numerics/overdetermined_system.hpp"

#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/foundation/numerics/extrema.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <utility>

namespace balance::numerics {

double pivot_ratio(const ColumnPivotingQr& factors) {
  const Eigen::Index n = factors.cols();
  if (n == 0) return 1;
  if (factors.rows() < n) return 0;
  const double largest = factors.maxPivot();
  return largest > 0 ? std::abs(factors.matrixQR()(n - 1, n - 1)) / largest : 0;
}

/// A P = Q R implies A⁺ = P R⁻¹ Qᵀ, whose rows have the same norms as those of R⁻¹.
double pseudo_inverse_regularity(const ColumnPivotingQr& factors) {
  const Eigen::Index n = factors.cols();
  if (n == 0) return 1;
  if (!(pivot_ratio(factors) > 0)) return 0;
  const auto R = factors.matrixR().topLeftCorner(n, n).triangularView<Eigen::Upper>();
  const MatrixX inverse = R.solve(MatrixX::Identity(n, n));
  Eigen::Index max_norm_row = 0;
  for (Eigen::Index row = 1; row < n; ++row)
    if (inverse.row(row).squaredNorm() > inverse.row(max_norm_row).squaredNorm()) max_norm_row = row;
  VectorX entries = VectorX::Zero(factors.rows());
  entries.head(n) = inverse.row(max_norm_row).transpose();
  entries.applyOnTheLeft(factors.householderQ());
  const double regularity = 1 / max_abs(entries);
  return std::isfinite(regularity) ? std::min(1.0, regularity) : 0;
}

bool is_near_stored(const ColumnPivotingQr& factors, const MatrixX& current, const MatrixX& stored, double limit) {
  if (current.cols() == 0) return true;
  const MatrixX change = current - stored;
  // The pseudo-inverse hardly ever exceeds the size divided by the smallest pivot.
  const double max_row_sum = max_abs(change.cwiseAbs().rowwise().sum());
  const double pivot = pivot_ratio(factors) * factors.maxPivot();
  if (4 * static_cast<double>(current.cols()) * max_row_sum <= limit * pivot) return true;
  const MatrixX relative = factors.solve(change);
  return max_abs(relative.cwiseAbs().rowwise().sum()) <= limit;  // false for NaN
}

double smallest_singular_value(const MatrixX& matrix) {
  if (matrix.cols() == 0) return 1;
  return singular_values(matrix)[matrix.cols() - 1];
}

double RankMonitor::factorise(MatrixX matrix) {
  current_ = std::move(matrix);
  factors_.compute(current_);
  return pseudo_inverse_regularity(factors_);
}

/// A − θ (A − K) = A (1 − θ (1 − A⁺K)) is singular if A⁺K has the eigenvalue 1 − 1/θ, which is not positive for 0 < θ ≤
/// 1.
bool RankMonitor::loses_rank_since_stored() const {
  constexpr double max_relative_change = 0.7,
                   real_eigenvalue_tolerance = 1e-6;  // round-off turns equal eigenvalues into complex pairs
  if (is_near_stored(max_relative_change)) return false;
  const MatrixX relative = factors_.solve(stored_);
  if (!relative.allFinite()) return true;
  const Eigen::VectorXcd values = Eigen::EigenSolver<MatrixX>(relative, false).eigenvalues();
  return std::any_of(values.begin(), values.end(), [](const std::complex<double>& value) {
    return value.real() <= 0 && std::abs(value.imag()) <= real_eigenvalue_tolerance * std::abs(value);
  });
}

}  // namespace balance::numerics
