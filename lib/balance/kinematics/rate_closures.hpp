#pragma once
/// Closures that bind rates and not places: of what rolls on a plane, and of constraints on speeds. Private to kinematics.

#include "balance/kinematics/tree.hpp"

namespace balance {

/// A frame fixed to what another frame is fixed to.
/// @param R, p in that frame's axes, from its origin
template <class S>
FixedFrame<S> offset_frame(const FixedFrame<S>& body, const Matrix3Of<typename S::Scalar>& R,
                           const Vector3Of<typename S::Scalar>& p) {
  return {body.node, body.R_N * to_rotation<S>(R), body.p_N + body.R_N * to_vector<S>(p)};
}

/// What the coordinates of a joint that rolls leave to their rates: no slip where it touches. Its path is to be found yet.
/// @param j the joint's index
template <class S>
Closure<S> make_rolling_closure(const Tree<S>& tree, const JointOf<typename S::Scalar>& joint, int j);

/// A sum of speeds that is zero, with its path.
template <class S>
Closure<S> make_speed_closure(const Tree<S>& tree, const GeneralisedSpeedOf<typename S::Scalar>& constraint);

}  // namespace balance
