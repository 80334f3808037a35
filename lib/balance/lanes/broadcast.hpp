#pragma once
/// A tree whose numbers are the same in every lane. Private to lanes.

#include "balance/kinematics/tree.hpp"

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

/// What the recursions over an open tree read.
/// @tparam L the space S over packs
template <class L, class S>
Tree<L> broadcast(const Tree<S>& tree) {
  using T = typename L::Scalar;
  Tree<L> lanes;
  lanes.columns = tree.columns;
  for (const Node<S>& node : tree.nodes)
    lanes.nodes.push_back({.parent = node.parent,
                           .motion = node.motion,
                           .column = node.column,
                           .ratio = T(node.ratio),
                           .offset = T(node.offset),
                           .R_PF = broadcast<T>(node.R_PF),
                           .p_PF = node.p_PF.template cast<T>(),
                           .inertia = broadcast<T>(node.inertia),
                           .massless = node.massless});
  return lanes;
}

}  // namespace balance
