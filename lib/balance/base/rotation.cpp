#include "balance/base/rotation.hpp"

#include <Eigen/Geometry>

#include <cmath>
#include <numbers>

namespace balance {

Matrix3 skew(const Vector3& a) {
  Matrix3 s;
  s << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
  return s;
}

Matrix3 rotation_about(const Vector3& axis, double angle) {
  const Matrix3 k = skew(axis);
  return Matrix3::Identity() + std::sin(angle) * k + (1 - std::cos(angle)) * k * k;
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
  // near the identity angle / sin(angle / 2) tends to 2
  return sine < 1e-9 ? Vector3(2 * v) : Vector3(2 * std::atan2(sine, q[0]) / sine * v);
}

Matrix3 rotation_from_vector(const Vector3& v) {
  const double angle = v.norm();
  return angle == 0 ? Matrix3::Identity() : rotation_about(v / angle, angle);
}

Matrix3 frame_with_z_along(const Vector3& direction) {
  const double x = direction.x(), y = direction.y(), z = direction.z(), sine2 = x * x + y * y;
  if (sine2 < 1e-40) return z > 0 ? Matrix3::Identity() : Matrix3(Vector3(1, -1, -1).asDiagonal());
  // 1 / (1 + z), which nothing may cancel in where the direction is nearly opposite to z
  const double k = z > 0 ? 1 / (1 + z) : (1 - z) / sine2;
  Matrix3 r;
  r << z + y * y * k, -x * y * k, x,  //
      -x * y * k, z + x * x * k, y,   //
      -x, -y, z;
  return r;
}

}  // namespace balance
