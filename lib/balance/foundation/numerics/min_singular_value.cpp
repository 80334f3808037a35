#include "balance/foundation/numerics/min_singular_value.hpp"

#include "balance/foundation/base/elementary.hpp"
#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/foundation/numerics/extrema.hpp"

#include <algorithm>
#include <cmath>
#include <random>

namespace balance {

namespace {

constexpr int max_laguerre_iterations = 200;  // four or five, more where the smallest eigenvalue is a multiple one

struct LaguerreSums {
  double first = 0, second = 0;  ///< Σ 1/(λ − x) and Σ 1/(λ − x)² over all eigenvalues
  bool below = true;             ///< x is below all of them
};

/// By the pivots of T − x and their derivatives with respect to x.
LaguerreSums laguerre_sums(const std::vector<double>& diagonal, const std::vector<double>& beside, double x) {
  LaguerreSums sums;
  double pivot = 1, slope = 0, curvature = 0;  // the last pivot, its derivatives by the pivot
  for (std::size_t i = 0; i < diagonal.size(); ++i) {
    const double passed = i > 0 ? beside[i - 1] * beside[i - 1] / pivot : 0;
    const double first = -1 + passed * slope, second = passed * (curvature - 2 * slope * slope);
    pivot = diagonal[i] - x - passed;
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

/// To diagonal_ and beside_: reflections from both sides, one column after another.
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
    double along = 0;
    for (int i = k + 1; i < n_; ++i) {
      double sum = 0;
      for (int j = k + 1; j < n_; ++j) sum += matrix_[i * n_ + j] * vector_[j];
      image_[i] = factor * sum;
      along += image_[i] * vector_[i];
    }
    for (int i = k + 1; i < n_; ++i) image_[i] -= factor / 2 * along * vector_[i];
    for (int i = k + 1; i < n_; ++i)
      for (int j = k + 1; j < n_; ++j) matrix_[i * n_ + j] -= vector_[i] * image_[j] + image_[i] * vector_[j];
  }
}

double MinSingularValue::compute_from_normal_matrix() {
  for (int i = 0; i < n_; ++i)
    for (int j = 0; j < i; ++j) matrix_[i * n_ + j] = matrix_[j * n_ + i];
  tridiagonalise();
  double least = 0;
  for (int steps = 0; steps < max_laguerre_iterations; ++steps) {
    const LaguerreSums sums = laguerre_sums(diagonal_, off_diagonal_, least);
    if (!sums.below) break;  // there, up to round-off
    const double spread = std::max(0.0, (n_ - 1) * (n_ * sums.second - sums.first * sums.first));
    const double step = n_ / (sums.first + std::sqrt(spread));
    least += step;
    if (!(step > 1e-15 * least)) break;
  }
  return std::sqrt(least);
}

/// AᵀA − value² is positive definite beyond the doubt of round-off.
bool MinSingularValue::is_below_spectrum(double value) {
  double trace = 0;
  for (int i = 0; i < n_; ++i) trace += matrix_[i * n_ + i];
  const double doubt = 4e-16 * n_ * trace;
  shifted_ = matrix_;
  for (int k = 0; k < n_; ++k) {
    double* row = &shifted_[k * n_];
    const double pivot = row[k] - value * value;
    if (!(pivot > doubt)) return false;
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
  constexpr int most = 12;
  constexpr double inverse_iteration_tolerance = 1e-10, lower_bound_margin = 2e-9;
  if (skipped_ > 0) {
    --skipped_;
    return {};
  }
  if (static_cast<int>(guess_.size()) != n_) {
    guess_.resize(n_);
    for (int i = 0; i < n_; ++i) guess_[i] = 1 + 0.3 * elementary::sin(i + 1);  // in no likely singular direction
  }
  double value = INFINITY, change = INFINITY;
  for (int step = 0; step < most; ++step) {
    factors.solve_transposed(guess_.data());
    double before = 0, after = 0;
    for (int i = 0; i < n_; ++i) before += guess_[i] * guess_[i];
    factors.solve(guess_.data());
    for (int i = 0; i < n_; ++i) after += guess_[i] * guess_[i];
    const double last = value, scale = 1 / std::sqrt(after);
    value = std::sqrt(before) * scale;  // ‖A x‖ / ‖x‖ of the vector that is the guess now
    for (int i = 0; i < n_; ++i) guess_[i] *= scale;
    const double rate = std::abs(value - last) / change;
    change = std::abs(value - last);
    if (!(change <= inverse_iteration_tolerance * value)) {
      if (step < 3 || elementary::pow(rate, most - step) * change <= inverse_iteration_tolerance * value) continue;
      break;  // two values are near each other
    }
    if (!is_below_spectrum((1 - lower_bound_margin) * value)) break;
    backoff_ = 0;
    return value;
  }
  guess_.clear();
  skipped_ = backoff_ = std::min(2 * backoff_ + 1, 63);
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
  constexpr int most = 60;
  std::minstd_rand random(1);
  MatrixX basis(n, std::min(most, n));
  VectorX next = VectorX::NullaryExpr(n, [&] { return static_cast<double>(random()) / random.max() - 0.5; });
  VectorX diagonal(basis.cols()), beside(basis.cols());
  double length = next.norm();
  for (int k = 0; k < basis.cols(); ++k) {
    basis.col(k) = next / length;
    next = basis.col(k);
    inverse(next);
    diagonal[k] = basis.col(k).dot(next);
    const auto known = basis.leftCols(k + 1);
    for (int twice = 0; twice < 2; ++twice) next -= known * (known.transpose() * next).eval();
    beside[k] = length = next.norm();
    const bool whole = k + 1 == basis.cols() || length <= 1e-13 * max_coefficient(diagonal.head(k + 1));
    if (k % 4 != 3 && !whole) continue;  // to look takes longer than a step
    SymmetricEigenSolver ritz;
    ritz.computeFromTridiagonal(diagonal.head(k + 1), beside.head(k));
    const double largest = ritz.eigenvalues()[k];
    const bool converged = length * std::abs(ritz.eigenvectors()(k, k)) <= 1e-10 * largest;
    if (converged && (k + 1 >= steps || length <= 1e-13 * largest)) return 1 / std::sqrt(largest);
  }
  return {};
}

}  // namespace balance
