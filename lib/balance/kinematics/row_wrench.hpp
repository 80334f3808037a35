#pragma once
/// Wrenches as rows: what a force and a moment on a body do to the coordinates of the nodes that carry it. Private to kinematics, motion and
/// dynamics.

#include "balance/kinematics/state.hpp"

namespace balance {

template <class S>
struct ConstraintWrench {
  typename S::Vector force = S::Vector::Zero();  ///< world axes, through Q
  typename S::Angular moment = S::zero_angular();
};

/// Rate, per unit rate of the node's coordinate, of a wrench's power at the point Q of what the node carries.
template <class S>
inline typename S::Scalar wrench_power(const Node<Constants<S>>& node, const NodeState<S>& state,
                                       const typename S::Vector& Q, const ConstraintWrench<S>& wrench) {
  if (node.motion == NodeMotion::prismatic) return node.ratio * dot(wrench.force, prismatic_axis(state.R_WN));
  return node.ratio * dot(revolute_axis(state.R_WN),
                          typename S::Angular(wrench.moment + cross(typename S::Vector(Q - state.p_WN), wrench.force)));
}

}  // namespace balance
