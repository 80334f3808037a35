#include "balance/foundation/base/rotation.hpp"

#include "balance/foundation/base/elementary.hpp"

#include <Eigen/Geometry>

#include <cmath>
#include <numbers>

namespace balance {

Matrix3 rotation_about(const Vector3& axis, double angle) {
  const Matrix3 k = skew(axis);
  return Matrix3::Identity() + elementary::sin(angle) * k + (1 - elementary::cos(angle)) * k * k;
}

Matrix3 rotation_from_rpy(const Vector3& rpy) {
  return rotation_about(Vector3::UnitZ(), rpy.z()) * rotation_about(Vector3::UnitY(), rpy.y()) *
         rotation_about(Vector3::UnitX(), rpy.x());
}

Eigen::Vector4d quaternion_of(const Matrix3& rotation) {
  Eigen::Quaterniond q(rotation);
  if (q.w() < 0) q.coeffs() *= -1;
  return {q.w(), q.x(), q.y(), q.z()};
}

Vector3 rotation_vector_of(const Matrix3& rotation) {
  const Eigen::Vector4d q = quaternion_of(rotation);
  const Vector3 v = q.tail<3>();
  const double sine = v.norm();
  // angle / sin(angle / 2) tends to 2 near the identity
  return sine < 1e-9 ? Vector3(2 * v) : Vector3(2 * elementary::atan2(sine, q[0]) / sine * v);
}

Matrix3 rotation_from_rotation_vector(const Vector3& v) {
  const double angle = v.norm();
  return angle == 0 ? Matrix3::Identity() : rotation_about(v / angle, angle);
}

}  // namespace balance
