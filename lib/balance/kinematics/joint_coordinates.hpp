#pragma once
/// Coordinates of joints that the tree does not use: read off the relative motion of the two bodies.
/// Private to kinematics, motion and dynamics.

#include "balance/kinematics/state.hpp"

#include <array>
#include <vector>

namespace balance {

/// Up to three coordinates of one joint with their derivatives.
struct JointReading {
  std::array<double, 3> position{}, velocity{}, acceleration{};
};

/// Motion of a joint's second body seen by an observer on its first, in the first body's axes.
struct RelativeMotion {
  Matrix3 rotation;         ///< of the second body's frame, less the joint's own constant rotation
  Vector3 place;            ///< from the joint's point on the first body to that on the second
  Vector3 slip, slip_rate;  ///< its first and second derivative
  Vector3 spin, spin_rate;  ///< relative angular velocity and acceleration
};

/// @param state poses; for the rates also velocities and accelerations
template <class S>
RelativeMotion relative_motion(const Tree<S>& tree, const State<S>& state, const Joint& joint);

/// Angles in (−π, π]. Rates of a spherical joint are infinite at its second angle ±π/2.
JointReading read_joint(const Joint& joint, const RelativeMotion& motion);

/// The value that differs from `angle` by whole turns and is nearest to `reference`.
double unwrapped(double angle, double reference);

/// All coordinates of the mechanism at y, cut joints and floating spherical ones included, angles in (−π, π].
template <class S>
std::vector<double> read_coordinates(const Mechanism& mechanism, const Tree<S>& tree, const VectorX& y);

extern template std::vector<double> read_coordinates<Planar>(const Mechanism&, const Tree<Planar>&, const VectorX&);
extern template std::vector<double> read_coordinates<Spatial>(const Mechanism&, const Tree<Spatial>&, const VectorX&);
extern template RelativeMotion relative_motion<Planar>(const Tree<Planar>&, const State<Planar>&, const Joint&);
extern template RelativeMotion relative_motion<Spatial>(const Tree<Spatial>&, const State<Spatial>&, const Joint&);

}  // namespace balance
