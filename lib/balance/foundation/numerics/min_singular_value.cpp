#include "balance/foundation/numerics/min_singular_value.hpp"

#include "balance/foundation/base/elementary.hpp"
#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/foundation/numerics/extrema.hpp"

#include <algorithm>
#include <cmath>
#include <random>

namespace balance::numerics {

namespace {

constexpr int max_laguerre_iterations = 200;  // usually four or five; more for a multiple smallest eigenvalue

struct LaguerreSums {
  double first = 0, second = 0;  ///< Σ 1/(λ − x) and Σ 1/(λ − x)² over all eigenvalues λ
  bool is_lower_bound = true;    ///< x is below all of them
};

/// Computed from the pivots of T − x and their derivatives with respect to x.
LaguerreSums laguerre_sums(const std::vector<double>& diagonal, const std::vector<double>& off_diagonal, double x) {
  LaguerreSums sums;
  double pivot = 1, slope = 0, curvature = 0;  // the last pivot; its first and second derivative divided by it
  for (std::size_t i = 0; i < diagonal.size(); ++i) {
    const double correction = i > 0 ? off_diagonal[i - 1] * off_diagonal[i - 1] / pivot : 0;
    const double first = -1 + correction * slope, second = correction * (curvature - 2 * slope * slope);
    pivot = diagonal[i] - x - correction;
    if (!(pivot > 0)) return {0, 0, false};
    slope = first / pivot;
    curvature = second / pivot;
    sums.first -= slope;
    sums.second -= curvature - slope * slope;
  }
  return sums;
}

}  // namespace

double* MinSingularValue::normal_matrix(int n) {
  n_ = n;
  matrix_.resize(static_cast<std::size_t>(n) * n);
  for (std::vector<double>* vector : {&diagonal_, &off_diagonal_, &vector_, &image_}) vector->resize(n);
  return matrix_.data();
}

/// Writes diagonal_ and off_diagonal_: reflections from both sides, column by column.
void MinSingularValue::tridiagonalise() {
  for (int k = 0; k < n_; ++k) {
    const double* pivot_row = &matrix_[k * n_];
    diagonal_[k] = pivot_row[k];
    off_diagonal_[k] = 0;
    double tail = 0;
    for (int i = k + 2; i < n_; ++i) tail += pivot_row[i] * pivot_row[i];
    if (k + 1 < n_) off_diagonal_[k] = pivot_row[k + 1];
    if (tail == 0) continue;
    const double head = pivot_row[k + 1];
    off_diagonal_[k] = -std::copysign(std::sqrt(head * head + tail), head);
    std::copy(pivot_row + k + 1, pivot_row + n_, &vector_[k + 1]);
    vector_[k + 1] -= off_diagonal_[k];
    const double factor = 2 / (vector_[k + 1] * vector_[k + 1] + tail);
    double projection = 0;
    for (int i = k + 1; i < n_; ++i) {
      double sum = 0;
      for (int j = k + 1; j < n_; ++j) sum += matrix_[i * n_ + j] * vector_[j];
      image_[i] = factor * sum;
      projection += image_[i] * vector_[i];
    }
    for (int i = k + 1; i < n_; ++i) image_[i] -= factor / 2 * projection * vector_[i];
    for (int i = k + 1; i < n_; ++i)
      for (int j = k + 1; j < n_; ++j) matrix_[i * n_ + j] -= vector_[i] * image_[j] + image_[i] * vector_[j];
  }
}

double MinSingularValue::compute_from_normal_matrix() {
  for (int i = 0; i < n_; ++i)
    for (int j = 0; j < i; ++j) matrix_[i * n_ + j] = matrix_[j * n_ + i];
  tridiagonalise();
  double eigenvalue = 0;
  for (int iteration = 0; iteration < max_laguerre_iterations; ++iteration) {
    const LaguerreSums sums = laguerre_sums(diagonal_, off_diagonal_, eigenvalue);
    if (!sums.is_lower_bound) break;  // converged, up to round-off
    const double discriminant = std::max(0.0, (n_ - 1) * (n_ * sums.second - sums.first * sums.first));
    const double step = n_ / (sums.first + std::sqrt(discriminant));
    eigenvalue += step;
    if (!(step > 1e-15 * eigenvalue)) break;
  }
  return std::sqrt(eigenvalue);
}

/// Whether AᵀA − value² is positive definite beyond round-off.
bool MinSingularValue::is_below_spectrum(double value) {
  double trace = 0;
  for (int i = 0; i < n_; ++i) trace += matrix_[i * n_ + i];
  const double round_off_bound = 4e-16 * n_ * trace;
  shifted_ = matrix_;
  for (int k = 0; k < n_; ++k) {
    double* row = &shifted_[k * n_];
    const double pivot = row[k] - value * value;
    if (!(pivot > round_off_bound)) return false;
    const double inverse = 1 / pivot;
    for (int i = k + 1; i < n_; ++i) {
      const double factor = row[i] * inverse;
      if (factor == 0) continue;
      for (int j = i; j < n_; ++j) shifted_[i * n_ + j] -= factor * row[j];
    }
  }
  return true;
}

std::optional<double> MinSingularValue::compute_from_factors(BlockTriangular& factors) {
  constexpr int max_iterations = 12;
  constexpr double inverse_iteration_tolerance = 1e-10, lower_bound_margin = 2e-9;
  if (calls_to_skip_ > 0) {
    --calls_to_skip_;
    return {};
  }
  if (static_cast<int>(guess_.size()) != n_) {
    guess_.resize(n_);
    for (int i = 0; i < n_; ++i) guess_[i] = 1 + 0.3 * elementary::sin(i + 1);  // a generic vector
  }
  double value = INFINITY, change = INFINITY;
  for (int step = 0; step < max_iterations; ++step) {
    factors.solve_transposed(guess_.data());
    double half_step_squares = 0, full_step_squares = 0;
    for (int i = 0; i < n_; ++i) half_step_squares += guess_[i] * guess_[i];
    factors.solve(guess_.data());
    for (int i = 0; i < n_; ++i) full_step_squares += guess_[i] * guess_[i];
    const double previous_value = value, scale = 1 / std::sqrt(full_step_squares);
    value = std::sqrt(half_step_squares) * scale;  // ‖A x‖ / ‖x‖ for the new guess x
    for (int i = 0; i < n_; ++i) guess_[i] *= scale;
    const double rate = std::abs(value - previous_value) / change;
    change = std::abs(value - previous_value);
    if (!(change <= inverse_iteration_tolerance * value)) {
      if (step < 3 || elementary::pow(rate, max_iterations - step) * change <= inverse_iteration_tolerance * value)
        continue;
      break;  // two singular values are close to each other
    }
    if (!is_below_spectrum((1 - lower_bound_margin) * value)) break;
    backoff_ = 0;
    return value;
  }
  guess_.clear();
  calls_to_skip_ = backoff_ = std::min(2 * backoff_ + 1, 63);
  return {};
}

std::optional<double> min_singular_value_by_lanczos(BlockTriangular& matrix) {
  const auto inverse = [&](VectorX& x) {
    matrix.solve_transposed(x.data());
    matrix.solve(x.data());
  };
  return min_singular_value_by_lanczos(matrix.size(), inverse, 1);
}

std::optional<double> min_singular_value_by_lanczos(int n, const std::function<void(VectorX&)>& inverse, int steps) {
  constexpr int max_basis_size = 60;
  std::minstd_rand random(1);
  MatrixX basis(n, std::min(max_basis_size, n));
  VectorX next = VectorX::NullaryExpr(n, [&] { return static_cast<double>(random()) / random.max() - 0.5; });
  VectorX diagonal(basis.cols()), off_diagonal(basis.cols());
  double residual_norm = next.norm();
  for (int k = 0; k < basis.cols(); ++k) {
    basis.col(k) = next / residual_norm;
    next = basis.col(k);
    inverse(next);
    diagonal[k] = basis.col(k).dot(next);
    const auto basis_so_far = basis.leftCols(k + 1);
    for (int pass = 0; pass < 2; ++pass) next -= basis_so_far * (basis_so_far.transpose() * next).eval();
    off_diagonal[k] = residual_norm = next.norm();
    const bool is_exhausted = k + 1 == basis.cols() || residual_norm <= 1e-13 * max_coefficient(diagonal.head(k + 1));
    if (k % 4 != 3 && !is_exhausted) continue;  // a check takes longer than a step
    SymmetricEigenSolver ritz;
    ritz.computeFromTridiagonal(diagonal.head(k + 1), off_diagonal.head(k));
    const double largest = ritz.eigenvalues()[k];
    const bool converged = residual_norm * std::abs(ritz.eigenvectors()(k, k)) <= 1e-10 * largest;
    if (converged && (k + 1 >= steps || residual_norm <= 1e-13 * largest)) return 1 / std::sqrt(largest);
  }
  return {};
}

}  // namespace balance::numerics
