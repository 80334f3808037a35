// How far the equations' matrix is from a singular one.

#include "balance/base/factorizations.hpp"
#include "balance/base/number.hpp"
#include "balance/motion/equations.hpp"

#include <cmath>
#include <optional>

namespace balance {

namespace {

/// Singular vectors of the smallest value, of which duals alone are in need.
struct LeastDirections {
  VectorX left, right;
};

[[maybe_unused]] LeastDirections by_decomposition(const MatrixX& matrix) {
  const SingularValueDecomposition svd(matrix, Eigen::ComputeThinU | Eigen::ComputeThinV);
  const Eigen::Index last = svd.singularValues().size() - 1;
  return {svd.matrixU().col(last), svd.matrixV().col(last)};
}

/// Inverse iteration on the factors at hand. @return nothing where two values are near each other
[[maybe_unused]] std::optional<LeastDirections> by_factors(BlockTriangular& factors) {
  constexpr int most = 24;
  constexpr double settled = 1e-13;
  const int n = factors.size();
  VectorX right = VectorX::LinSpaced(n, 1, 1.3).normalized(), left;
  for (int step = 0; step < most; ++step) {
    left = right;
    factors.solve_transposed(left.data());
    VectorX next = left;
    factors.solve(next.data());
    next.normalize();
    left.normalize();
    const double change = (next - right).norm();
    right = next;
    if (step >= 3 && change < settled * std::sqrt(n)) return LeastDirections{left, right};
  }
  return std::nullopt;
}

}  // namespace

template <class S>
typename S::Scalar Equations<S>::least_singular_value() {
  if (columns() == 0) return 1;
  if constexpr (!std::is_same_v<T, double>) {  // dσ = uᵀ dA v
    std::optional<LeastDirections> found;
    // duals are filled anew with other derivatives of the same values
    if (!redundant_ && regularity_ > 0) found = by_factors(values_of(sparse_));
    if (!found) found = by_decomposition(dense());
    T least = 0;
    for (int r = 0; r < rows(); ++r)
      for (int c = 0; c < columns(); ++c) least += found->left[r] * found->right[c] * entry(r, c);
    return least;
  } else {
    const int n = columns();
    if (!redundant_ && n > most_dense && factorise())
      if (const std::optional<double> value = least_singular_by_inverse(sparse_)) return *value;
    double* normal = least_singular_.normal(n);
    if (redundant_) {
      Eigen::Map<Samples>(normal, n, n).noalias() = tall_.dense().transpose() * tall_.dense();
      return least_singular_.of_normal();
    }
    sparse_.write_normal(normal);  // in the order of the storage, which changes no singular value
    if (factorised_ == filled_ && regularity_ > 0)
      if (const std::optional<double> value = least_singular_.of_factors(sparse_)) return *value;
    return least_singular_.of_normal();
  }
}

template <class S>
MatrixX Equations<S>::dense() const {
  MatrixX matrix(rows(), columns());
  for (int r = 0; r < rows(); ++r)
    for (int c = 0; c < columns(); ++c) matrix(r, c) = value_of(entry(r, c));
  return matrix;
}

template <class S>
double Equations<S>::distance_from_singular() const {
  if (!redundant_ && columns() > most_dense) {
    SquareSystem<T> factors = sparse_;
    if (factors.factorise() > 0)
      if (const std::optional<double> value = least_singular_by_inverse(values_of(factors))) return *value;
  }
  return smallest_singular_value(dense());
}

template Number Equations<PlanarOf<Number>>::least_singular_value();
template Number Equations<SpatialOf<Number>>::least_singular_value();
template MatrixX Equations<PlanarOf<Number>>::dense() const;
template MatrixX Equations<SpatialOf<Number>>::dense() const;
template double Equations<PlanarOf<Number>>::distance_from_singular() const;
template double Equations<SpatialOf<Number>>::distance_from_singular() const;

}  // namespace balance
