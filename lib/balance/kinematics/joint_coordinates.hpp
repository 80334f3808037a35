#pragma once
/// Coordinates of joints that the tree does not use: read off the relative motion of the two bodies.
/// Private to kinematics, motion and dynamics.

#include "balance/kinematics/state.hpp"

#include <array>
#include <cmath>
#include <numbers>
#include <vector>

namespace balance {

/// Up to five coordinates of one joint with their derivatives.
template <class T>
struct JointMotion {
  std::array<T, 5> position{}, velocity{}, acceleration{};
};

/// Motion of a joint's second body seen by an observer on its first, in the first body's axes.
template <class T>
struct RelativeMotion {
  Matrix3Of<T> rotation;      ///< of the second body's frame, less the joint's own constant rotation
  Vector3Of<T> displacement;  ///< from the joint's point on the first body to that on the second
  Vector3Of<T> linear_velocity, linear_acceleration;    ///< its first and second derivative
  Vector3Of<T> angular_velocity, angular_acceleration;  ///< relative angular velocity and acceleration
};

/// @param state poses; for the rates also velocities and accelerations
template <class S>
RelativeMotion<typename S::Scalar> relative_motion(const Tree<S>& tree, const TreeState<S>& state,
                                                   const JointOf<typename S::Scalar>& joint);

/// Angles in (−π, π]. Rates of a spherical joint are infinite at its second angle ±π/2.
template <class T>
JointMotion<T> compute_joint_motion(const JointOf<T>& joint, const RelativeMotion<T>& motion);

/// The value that differs from `angle` by whole turns and is nearest to `reference`.
template <class T>
T unwrap_angle(const T& angle, double reference) {
  constexpr double two_pi = 2 * std::numbers::pi;
  return angle + two_pi * std::round((reference - value_of(angle)) / two_pi);
}

/// All coordinates of the mechanism at y, cut joints and floating spherical ones included, angles in (−π, π].
template <class S>
std::vector<double> compute_coordinates(const Mechanism& mechanism, const Tree<S>& tree, const VectorX& y);

extern template std::vector<double> compute_coordinates<Planar>(const Mechanism&, const Tree<Planar>&, const VectorX&);
extern template std::vector<double> compute_coordinates<Spatial>(const Mechanism&, const Tree<Spatial>&,
                                                                 const VectorX&);

}  // namespace balance
