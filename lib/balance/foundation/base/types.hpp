#pragma once
/// Eigen types under the names that this program uses. Every quantity is in SI units and world axes unless its name or
/// comment says otherwise.

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <cstddef>
#include <utility>

namespace balance {

// For any scalar.
template <class T>
using Vector2Of = Eigen::Matrix<T, 2, 1>;
template <class T>
using Vector3Of = Eigen::Matrix<T, 3, 1>;
template <class T>
using Matrix3Of = Eigen::Matrix<T, 3, 3>;
template <class T>
using VectorXOf = Eigen::Matrix<T, Eigen::Dynamic, 1>;

/// Scalar of the parameters of a mechanism whose motion has the scalar T: T itself, unless a T holds several motions
/// (foundation/base/pack.hpp).
template <class T>
struct ModelScalarTraits {
  using Type = T;
};
template <class T>
using ModelScalarOf = typename ModelScalarTraits<T>::Type;

template <class A, class B>
using ProductOf = decltype(std::declval<A>() * std::declval<B>());

/// Alignment [bytes] of storage for such numbers: stricter than usual if one number fills a register
/// (foundation/base/pack.hpp).
template <class T>
inline constexpr std::size_t storage_alignment = alignof(std::max_align_t);

using Vector2 = Vector2Of<double>;
using Vector3 = Vector3Of<double>;
using Matrix3 = Matrix3Of<double>;
using VectorX = VectorXOf<double>;
using MatrixX = Eigen::MatrixXd;
/// One row per sample, contiguous in memory: the layout of the result file.
using Samples = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

}  // namespace balance
