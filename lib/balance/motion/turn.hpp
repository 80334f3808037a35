#pragma once
/// Rotations along one parameter s in [0, 1]. Each fills a sample's rotation, angular velocity and angular
/// acceleration (world axes) from s and its time derivatives. Immutable; filling allocates nothing.

#include "balance/motion/law.hpp"
#include "balance/motion/schedule.hpp"
#include "balance/motion/spline.hpp"

#include <variant>
#include <vector>

namespace balance {

/// No rotation is prescribed.
struct NoRotation {
  void fill(const MotionLawValue& progress, DriveSample& sample) const;
};

/// About one world axis, by `angle` at s = 1.
struct FixedAxisRotation {
  Matrix3 start;
  Vector3 axis;      ///< unit, world axes
  double angle = 0;  ///< [rad]

  void fill(const MotionLawValue& progress, DriveSample& sample) const;
};

/// R(s) = exp(φ(s)) · reference, where the rotation vector φ is a C² spline: so R is C², and where all orientations
/// share one axis it is the spline of the angle.
struct SplineRotation {
  Matrix3 reference;
  CubicSpline rotation_vector;  ///< three components [rad], world axes

  void fill(const MotionLawValue& progress, DriveSample& sample) const;
};

using RotationCurve = std::variant<NoRotation, FixedAxisRotation, SplineRotation>;

/// The shortest rotation. At exactly half a turn, where there are two, it takes either.
FixedAxisRotation find_shortest_rotation(const Matrix3& from, const Matrix3& to);

/// Through all rotations, each to the next by less than half a turn.
/// @param knots increasing, one per rotation
/// @throws std::invalid_argument if they wander too far apart for a rotation vector to follow. The message is fit for
///        a user.
SplineRotation interpolate_rotations(const std::vector<double>& knots, const std::vector<Matrix3>& rotations);

/// Through rotation vectors (rows of three), natural reading: a row that another rotation vector of the same rotation
/// brings nearer to the row before is replaced by that one, so that a jump from +π to −π does no harm.
SplineRotation interpolate_rotation_vectors(const std::vector<double>& knots, Samples vectors);

}  // namespace balance
