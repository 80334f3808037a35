#pragma once
/// Wrenches as rows: what a force and a moment on a body do to the coordinates of the nodes that carry it. Private to kinematics, motion and
/// dynamics.

#include "balance/kinematics/state.hpp"

namespace balance {

template <class S>
struct RowWrench {
  typename S::Vector force = S::Vector::Zero();  ///< world axes, through Q
  typename S::Angular moment = S::zero_angular();
};

/// Rate, per unit rate of the node's coordinate, of a wrench's power at the point Q of what the node carries.
template <class S>
inline typename S::Scalar power_of(const Node<Constants<S>>& node, const NodeState<S>& state,
                                   const typename S::Vector& Q, const RowWrench<S>& wrench) {
  if (node.motion == NodeMotion::slide) return node.ratio * dot(wrench.force, slide_axis(state.R_WN));
  return node.ratio * dot(turn_axis(state.R_WN),
                          typename S::Angular(wrench.moment + cross(typename S::Vector(Q - state.p_WN), wrench.force)));
}

}  // namespace balance
