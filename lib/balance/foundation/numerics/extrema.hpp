#pragma once
/// Largest and smallest entries of arrays that may be empty, for which Eigen's maxCoeff and minCoeff read out of
/// bounds.

#include "balance/foundation/base/types.hpp"

#include <limits>
#include <stdexcept>

namespace balance::numerics {

/// Largest absolute value, 0 if there are no entries.
template <class Derived>
auto max_abs(const Eigen::DenseBase<Derived>& entries) {
  using Real = typename Eigen::NumTraits<typename Derived::Scalar>::Real;
  return entries.size() == 0 ? Real(0) : Real(entries.derived().cwiseAbs().maxCoeff());
}

/// Largest entry, -∞ if there are no entries.
template <class Derived>
typename Derived::Scalar max_coefficient(const Eigen::DenseBase<Derived>& entries) {
  using Scalar = typename Derived::Scalar;
  return entries.size() == 0 ? Scalar(-std::numeric_limits<double>::infinity()) : Scalar(entries.maxCoeff());
}

/// Smallest entry, +∞ if there are no entries.
template <class Derived>
typename Derived::Scalar min_coefficient(const Eigen::DenseBase<Derived>& entries) {
  using Scalar = typename Derived::Scalar;
  return entries.size() == 0 ? Scalar(std::numeric_limits<double>::infinity()) : Scalar(entries.minCoeff());
}

/// Largest entry of every row, -∞ if there are no columns.
template <class Derived>
Eigen::VectorXd row_maxima(const Eigen::DenseBase<Derived>& matrix) {
  if (matrix.cols() == 0) return Eigen::VectorXd::Constant(matrix.rows(), -std::numeric_limits<double>::infinity());
  return matrix.derived().rowwise().maxCoeff();
}

/// Index of a vector's largest entry.
/// @throws std::invalid_argument if there are no entries
template <class Derived>
Eigen::Index max_index(const Eigen::DenseBase<Derived>& vector) {
  if (vector.size() == 0) throw std::invalid_argument("max_index: a vector without entries has no largest one");
  Eigen::Index index = 0;
  vector.maxCoeff(&index);
  return index;
}

/// Index of a vector's smallest entry.
/// @throws std::invalid_argument if there are no entries
template <class Derived>
Eigen::Index min_index(const Eigen::DenseBase<Derived>& vector) {
  if (vector.size() == 0) throw std::invalid_argument("min_index: a vector without entries has no smallest one");
  Eigen::Index index = 0;
  vector.minCoeff(&index);
  return index;
}

}  // namespace balance::numerics
