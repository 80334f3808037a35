#pragma once
/// Smallest singular value of small matrices, one per lane, by the method of MinSingularValue: Householder
/// tridiagonalisation of AᵀA, then Laguerre's iteration, which stops separately for each lane.

#include "balance/mechanics/kinematics/kinematic_equations.hpp"

#include <utility>
#include <vector>

namespace balance::lanes {

/// @tparam L a space over packs
template <class L>
class LaneMinSingularValue {
 public:
  using T = typename L::Scalar;

  explicit LaneMinSingularValue(const kinematics::KinematicEquations<L>& equations) : n_(equations.columns()) {
    for (int r = 0; r < equations.rows(); ++r) {
      rows_.emplace_back();
      for (int c = 0; c < n_; ++c)
        if (const int storage_index = equations.entry_index(r, c); storage_index >= 0)
          rows_.back().push_back({storage_index, c});
    }
    matrix_.resize(static_cast<std::size_t>(n_) * n_);
    for (auto* vector : {&diagonal_, &subdiagonal_, &vector_, &image_}) vector->resize(static_cast<std::size_t>(n_));
  }

  /// @param equations evaluated
  T compute(const kinematics::KinematicEquations<L>& equations) {
    multiply(equations);
    tridiagonalise();
    T min_eigenvalue = 0.0;
    auto is_active = T(0.0) == T(0.0);
    for (int step = 0; step < max_laguerre_iterations; ++step) {
      const Sums sums = laguerre_sums(min_eigenvalue);
      is_active = is_active & sums.below;
      const double n = n_;
      const T discriminant = max(T(0.0), (n - 1) * (n * sums.second - sums.first * sums.first));
      const T change = n / (sums.first + sqrt(discriminant));
      min_eigenvalue = select(is_active, min_eigenvalue + change, min_eigenvalue);
      is_active = is_active & (change > 1e-15 * min_eigenvalue);
      if (!any(is_active)) break;
    }
    return sqrt(min_eigenvalue);
  }

 private:
  static constexpr int max_laguerre_iterations = 200;

  struct Sums {
    T first, second;
    decltype(T() < T()) below;
  };

  /// AᵀA.
  void multiply(const kinematics::KinematicEquations<L>& equations) {
    for (T& entry : matrix_) entry = 0.0;
    for (const auto& row : rows_)
      for (std::size_t i = 0; i < row.size(); ++i) {
        const T left_entry = equations.entry_at(row[i].first);
        for (std::size_t j = 0; j <= i; ++j)
          matrix_[static_cast<std::size_t>(row[i].second) * n_ + row[j].second] +=
              left_entry * equations.entry_at(row[j].first);
      }
    for (int i = 0; i < n_; ++i)
      for (int j = 0; j < i; ++j) matrix_[j * n_ + i] = matrix_[i * n_ + j];
  }

  void tridiagonalise() {
    for (int k = 0; k < n_; ++k) {
      const T* pivot_row = &matrix_[k * n_];
      diagonal_[k] = pivot_row[k];
      subdiagonal_[k] = 0.0;
      if (k + 1 == n_) break;
      const T head = pivot_row[k + 1];
      T tail = 0.0;
      for (int i = k + 2; i < n_; ++i) tail += pivot_row[i] * pivot_row[i];
      const T length = sqrt(head * head + tail);
      subdiagonal_[k] = select(head < 0.0, length, -length);
      for (int i = k + 1; i < n_; ++i) vector_[i] = pivot_row[i];
      vector_[k + 1] -= subdiagonal_[k];
      const T square = vector_[k + 1] * vector_[k + 1] + tail;
      reflect(k + 1, select(square > 0.0, 2.0 / square, T(0.0)));
    }
  }

  /// Applies the reflection by vector_ from both sides to the rows and columns from `begin` on.
  void reflect(int begin, const T& factor) {
    T projection = 0.0;
    for (int i = begin; i < n_; ++i) {
      T sum = 0.0;
      for (int j = begin; j < n_; ++j) sum += matrix_[i * n_ + j] * vector_[j];
      image_[i] = factor * sum;
      projection += image_[i] * vector_[i];
    }
    const T half = 0.5 * factor * projection;
    for (int i = begin; i < n_; ++i) image_[i] -= half * vector_[i];
    for (int i = begin; i < n_; ++i)
      for (int j = begin; j <= i; ++j) {
        const T entry = matrix_[i * n_ + j] - (vector_[i] * image_[j] + image_[i] * vector_[j]);
        matrix_[i * n_ + j] = matrix_[j * n_ + i] = entry;
      }
  }

  /// As in MinSingularValue.
  Sums laguerre_sums(const T& x) const {
    Sums sums{0.0, 0.0, T(0.0) == T(0.0)};
    T inverse = 0.0, slope = 0.0, curvature = 0.0;
    for (int i = 0; i < n_; ++i) {
      const T passed = i > 0 ? subdiagonal_[i - 1] * subdiagonal_[i - 1] * inverse : T(0.0);
      const T first = passed * slope - 1.0, second = passed * (curvature - 2.0 * slope * slope);
      const T pivot = diagonal_[i] - x - passed;
      sums.below = sums.below & (pivot > 0.0);
      inverse = 1.0 / pivot;
      slope = first * inverse;
      curvature = second * inverse;
      sums.first -= slope;
      sums.second -= curvature - slope * slope;
    }
    return sums;
  }

  int n_;
  std::vector<std::vector<std::pair<int, int>>> rows_;  ///< per row: storage index and column of each entry
  std::vector<T> matrix_, diagonal_, subdiagonal_, vector_, image_;
};

}  // namespace balance::lanes
