#pragma once
/// Directions and rotations as expressions.

#include "balance/spec/draft.hpp"

namespace balance::specification {

/// Entry by entry.
template <class Derived>
Eigen::Matrix<Expression, Derived::RowsAtCompileTime, Derived::ColsAtCompileTime> choose(
    const Expression& condition, const Eigen::MatrixBase<Derived>& yes, const Eigen::MatrixBase<Derived>& no) {
  Eigen::Matrix<Expression, Derived::RowsAtCompileTime, Derived::ColsAtCompileTime> result;
  for (Eigen::Index j = 0; j < result.cols(); ++j)
    for (Eigen::Index i = 0; i < result.rows(); ++i) result(i, j) = balance::select(condition, yes(i, j), no(i, j));
  return result;
}

/// v / |v|, without a care for zero.
Vector3E normalized(const Vector3E& v);
/// About a coordinate axis: 0, 1 or 2.
Matrix3E rotation_about(int axis, const Expression& angle);
/// Rz(yaw) Ry(pitch) Rx(roll) for (roll, pitch, yaw).
Matrix3E rotation_from_rpy(const Vector3E& rpy);
/// exp(skew(v)).
Matrix3E rotation_from_vector(const Vector3E& v);
/// Of (w, x, y, z), normalised first.
Matrix3E rotation_from_quaternion(const std::vector<Expression>& q);

Matrix3 values_of(const Matrix3E& matrix);
Vector3 values_of(const Vector3E& vector);

}  // namespace balance::specification
