#pragma once
/// Rotations in space. R_AB maps the components of a vector in B's axes to those in A's axes.

#include "balance/foundation/base/types.hpp"

namespace balance {

/// skew(a) b = a × b.
template <class T>
Matrix3Of<T> skew(const Vector3Of<T>& a) {
  Matrix3Of<T> s;
  s << T(0), -a.z(), a.y(), a.z(), T(0), -a.x(), -a.y(), a.x(), T(0);
  return s;
}
inline Matrix3 skew(const Vector3& a) { return skew<double>(a); }

/// Rotation about a unit axis by an angle [rad].
Matrix3 rotation_about(const Vector3& axis, double angle);

/// Rz(yaw) Ry(pitch) Rx(roll) for rpy = (roll, pitch, yaw) [rad].
Matrix3 rotation_from_rpy(const Vector3& rpy);

/// Unit quaternion (w, x, y, z) with w ≥ 0.
Eigen::Vector4d quaternion_of(const Matrix3& rotation);

/// The rotation vector (axis × angle, angle in [0, π]) whose exponential is the rotation.
Vector3 rotation_vector_of(const Matrix3& rotation);

/// exp(skew(v)).
Matrix3 rotation_from_rotation_vector(const Vector3& v);

/// The minimum-angle rotation that takes z to the unit vector `direction`; exact for the coordinate directions. Near
/// −z, where it is not unique: the minimum-angle rotation to (x, −y, −z), followed by half a turn about x.
template <class T>
Matrix3Of<T> frame_with_z_along(const Vector3Of<T>& direction) {
  const T x = direction.x(), y = direction.y(), z = direction.z(), sine2 = x * x + y * y;
  const bool opposite = z < 0 && sine2 < 1e-40;
  if (opposite) {
    Matrix3Of<T> r = frame_with_z_along<T>({x, -y, -z});
    r.template bottomRows<2>() *= T(-1);
    return r;
  }
  // 1 / (1 + z), without cancellation if the direction is nearly opposite to z
  const T k = z > 0 ? T(1 / (1 + z)) : T((1 - z) / sine2);
  Matrix3Of<T> r;
  r << z + y * y * k, -x * y * k, x,  //
      -x * y * k, z + x * x * k, y,   //
      -x, -y, z;
  return r;
}
inline Matrix3 frame_with_z_along(const Vector3& direction) { return frame_with_z_along<double>(direction); }

}  // namespace balance
