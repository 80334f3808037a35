#pragma once
/// A tree and a drive whose numbers are the same in every lane. Private to lanes.

#include "balance/kinematics/drive.hpp"

namespace balance {

template <class T>
PlanarRotation<T> broadcast(const PlanarRotation<double>& R) {
  return {T(R.c), T(R.s)};
}
template <class T>
SpatialRotation<T> broadcast(const SpatialRotation<double>& R) {
  return {R.matrix.template cast<T>()};
}
template <class T>
typename PlanarOf<T>::Inertia broadcast(const Planar::Inertia& inertia) {
  return {T(inertia.mass), inertia.moment.template cast<T>(), T(inertia.second)};
}
template <class T>
typename SpatialOf<T>::Inertia broadcast(const Spatial::Inertia& inertia) {
  return {T(inertia.mass), inertia.moment.template cast<T>(), inertia.second.template cast<T>()};
}
template <class L, class S>
FixedFrame<L> broadcast(const FixedFrame<S>& frame) {
  using T = typename L::Scalar;
  return {frame.node, broadcast<T>(frame.R_N), frame.p_N.template cast<T>()};
}
template <class L, class S>
Closure<L> broadcast(const Closure<S>& closure) {
  return {.joint = closure.joint,
          .split = closure.split,
          .a = broadcast<L>(closure.a),
          .b = broadcast<L>(closure.b),
          .rows = closure.rows,
          .pinned = closure.pinned,
          .aligned = closure.aligned,
          .path = closure.path};
}

/// What the recursions, closures and readings need.
/// @tparam L the space S over packs
template <class L, class S>
Tree<L> broadcast(const Tree<S>& tree) {
  using T = typename L::Scalar;
  Tree<L> lanes;
  for (const Node<S>& node : tree.nodes)
    lanes.nodes.push_back({.ratio = T(node.ratio),
                           .offset = T(node.offset),
                           .R_PF = broadcast<T>(node.R_PF),
                           .p_PF = node.p_PF.template cast<T>(),
                           .inertia = broadcast<T>(node.inertia),
                           .parent = node.parent,
                           .motion = node.motion,
                           .column = node.column,
                           .massless = node.massless});
  for (const FixedFrame<S>& body : tree.bodies) lanes.bodies.push_back(broadcast<L>(body));
  for (const Closure<S>& closure : tree.closures) lanes.closures.push_back(broadcast<L>(closure));
  lanes.columns = tree.columns;
  lanes.closure_rows = tree.closure_rows;
  lanes.slides = tree.slides;
  lanes.joint_nodes = tree.joint_nodes;
  lanes.joint_forward = tree.joint_forward;
  lanes.mass = T(tree.mass);
  lanes.length = tree.length;
  lanes.column_kind_length = tree.column_kind_length;
  return lanes;
}

template <class L, class S>
Drive<L> broadcast(const Drive<S>& drive) {
  using T = typename L::Scalar;
  Drive<L> lanes{.point = drive.point,
                 .com = drive.com,
                 .linear = {},
                 .rotation = drive.rotation,
                 .tool = broadcast<L>(drive.tool),
                 .tool_path = drive.tool_path};
  for (const LinearQuantity& quantity : drive.linear) {
    LinearQuantityOf<T>& linear = lanes.linear.emplace_back();
    for (const auto& [column, coefficient] : quantity.terms) linear.terms.emplace_back(column, T(coefficient));
    linear.constant = T(quantity.constant);
    linear.is_length = quantity.is_length;
  }
  return lanes;
}

}  // namespace balance
