#pragma once
/// Rotations of space. R_AB turns the components of a vector in B's axes into those in A's axes.

#include "balance/base/types.hpp"

namespace balance {

/// skew(a) b = a × b.
Matrix3 skew(const Vector3& a);

/// Rotation about a unit axis by an angle [rad].
Matrix3 rotation_about(const Vector3& axis, double angle);

/// Rz(yaw) Ry(pitch) Rx(roll) for rpy = (roll, pitch, yaw) [rad].
Matrix3 rotation_from_rpy(const Vector3& rpy);

/// Unit quaternion (w, x, y, z) with w ≥ 0.
Eigen::Vector4d quaternion_of(const Matrix3& rotation);

/// The rotation vector (axis × angle, angle in [0, π]) whose exponential is the rotation.
Vector3 rotation_vector_of(const Matrix3& rotation);

/// exp(skew(v)).
Matrix3 rotation_from_vector(const Vector3& v);

/// The rotation with the least angle that takes z to the unit vector `direction`; exact for the coordinate directions.
Matrix3 frame_with_z_along(const Vector3& direction);

}  // namespace balance
