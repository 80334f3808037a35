#include "balance/base/least_singular.hpp"

#include "balance/base/factorizations.hpp"

#include <algorithm>
#include <cmath>
#include <random>

namespace balance {

namespace {

constexpr int most_steps = 200;  // four or five, more where the smallest eigenvalue is a multiple one

struct LaguerreSums {
  double first = 0, second = 0;  ///< Σ 1/(λ − x) and Σ 1/(λ − x)² over all eigenvalues
  bool below = true;             ///< x is below all of them
};

/// By the pivots of T − x and their derivatives with respect to x.
LaguerreSums laguerre_sums(const std::vector<double>& diagonal, const std::vector<double>& beside, double x) {
  LaguerreSums sums;
  double pivot = 1, slope = 0, bend = 0;  // the last pivot, its derivatives by the pivot
  for (std::size_t i = 0; i < diagonal.size(); ++i) {
    const double passed = i > 0 ? beside[i - 1] * beside[i - 1] / pivot : 0;
    const double first = -1 + passed * slope, second = passed * (bend - 2 * slope * slope);
    pivot = diagonal[i] - x - passed;
    if (!(pivot > 0)) return {0, 0, false};
    slope = first / pivot;
    bend = second / pivot;
    sums.first -= slope;
    sums.second -= bend - slope * slope;
  }
  return sums;
}

}  // namespace

double* LeastSingular::normal(int n) {
  n_ = n;
  matrix_.resize(static_cast<std::size_t>(n) * n);
  for (std::vector<double>* vector : {&diagonal_, &beside_, &vector_, &image_}) vector->resize(n);
  return matrix_.data();
}

/// To diagonal_ and beside_: reflections from both sides, one column after another.
void LeastSingular::reduce() {
  for (int k = 0; k < n_; ++k) {
    const double* pivot_row = &matrix_[k * n_];
    diagonal_[k] = pivot_row[k];
    beside_[k] = 0;
    double tail = 0;
    for (int i = k + 2; i < n_; ++i) tail += pivot_row[i] * pivot_row[i];
    if (k + 1 < n_) beside_[k] = pivot_row[k + 1];
    if (tail == 0) continue;
    const double head = pivot_row[k + 1];
    beside_[k] = -std::copysign(std::sqrt(head * head + tail), head);
    std::copy(pivot_row + k + 1, pivot_row + n_, &vector_[k + 1]);
    vector_[k + 1] -= beside_[k];
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

double LeastSingular::of_normal() {
  reduce();
  double least = 0;
  for (int steps = 0; steps < most_steps; ++steps) {
    const LaguerreSums sums = laguerre_sums(diagonal_, beside_, least);
    if (!sums.below) break;  // there, up to round-off
    const double spread = std::max(0.0, (n_ - 1) * (n_ * sums.second - sums.first * sums.first));
    const double step = n_ / (sums.first + std::sqrt(spread));
    least += step;
    if (!(step > 1e-15 * least)) break;
  }
  return std::sqrt(least);
}

std::optional<double> least_singular_by_inverse(BlockTriangular& matrix) {
  constexpr int most = 60;
  const int n = matrix.size();
  std::minstd_rand random(1);
  MatrixX basis(n, std::min(most, n));
  VectorX next = VectorX::NullaryExpr(n, [&] { return static_cast<double>(random()) / random.max() - 0.5; });
  VectorX diagonal(basis.cols()), beside(basis.cols());
  double length = next.norm();
  for (int k = 0; k < basis.cols(); ++k) {
    basis.col(k) = next / length;
    next = basis.col(k);
    matrix.solve_transposed(next.data());
    matrix.solve(next.data());
    diagonal[k] = basis.col(k).dot(next);
    const auto known = basis.leftCols(k + 1);
    for (int twice = 0; twice < 2; ++twice) next -= known * (known.transpose() * next).eval();
    beside[k] = length = next.norm();
    Eigen::SelfAdjointEigenSolver<MatrixX> ritz;
    ritz.computeFromTridiagonal(diagonal.head(k + 1), beside.head(k));
    const double largest = ritz.eigenvalues()[k];
    if (length * std::abs(ritz.eigenvectors()(k, k)) <= 1e-10 * largest) return 1 / std::sqrt(largest);
  }
  return {};
}

}  // namespace balance
