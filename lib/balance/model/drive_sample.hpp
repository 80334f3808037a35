#pragma once
/// Values that a drive prescribes.

#include "balance/base/types.hpp"

namespace balance {

/// Prescribed values at one pose: k scalars (positions, planar angle, joint coordinates) and, where the whole orientation of
/// a spatial tool is prescribed, its rotation.
struct DriveValue {
  VectorX value;                           ///< k entries
  Matrix3 rotation = Matrix3::Identity();  ///< of the tool's body in the world; used only if the rotation is prescribed
};

/// Prescribed values at one time with their first and second time derivatives.
struct DriveSample {
  VectorX value, rate, acceleration;  ///< k entries each
  Matrix3 rotation = Matrix3::Identity();
  Vector3 angular_velocity = Vector3::Zero();      ///< world axes [rad/s]
  Vector3 angular_acceleration = Vector3::Zero();  ///< world axes [rad/s^2]
};

}  // namespace balance
