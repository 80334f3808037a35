#pragma once
/// Prescribed values of a drive.

#include "balance/foundation/base/types.hpp"

#include <limits>

namespace balance::trajectory {

/// Prescribed values at one pose: k scalars (positions, planar angle, joint coordinates) and, if the whole orientation
/// of a spatial tool is prescribed, its rotation.
template <class T>
struct DriveValueOf {
  VectorXOf<T> value;  ///< k entries
  Matrix3Of<T> rotation =
      Matrix3Of<T>::Identity();  ///< of the tool's body in the world; used only if the rotation is prescribed
};

/// Prescribed values at one time with their first and second time derivatives.
template <class T>
struct DriveSampleOf {
  VectorXOf<T> value, rate, acceleration;  ///< k entries each
  Matrix3Of<T> rotation = Matrix3Of<T>::Identity();
  Vector3Of<T> angular_velocity = Vector3Of<T>::Zero();      ///< world axes [rad/s]
  Vector3Of<T> angular_acceleration = Vector3Of<T>::Zero();  ///< world axes [rad/s^2]
  /// Time at which constraints on speeds take their values [s]; NaN: they are zero, as for variations of a motion.
  double constraint_time = std::numeric_limits<double>::quiet_NaN();
};

using DriveValue = DriveValueOf<double>;
using DriveSample = DriveSampleOf<double>;

}  // namespace balance::trajectory
