#pragma once
/// Inverse dynamics of the tree: recursive Newton–Euler from the leaves to the ground (Featherstone, Rigid Body Dynamics
/// Algorithms, 2008, table 5.1). Private to dynamics and the rooms that open it up.

#include "balance/kinematics/state.hpp"

#include <vector>

namespace balance {

/// What a node's parent exerts on the node and all it carries: node axes, moment about the node's origin.
template <class S>
struct alignas(storage_alignment<typename S::Scalar>) Wrench {
  typename S::Vector force = S::Vector::Zero();
  typename S::Angular moment = S::zero_angular();
};

/// Force and moment that give one node its acceleration.
template <class S>
inline Wrench<S> inertia_wrench(const typename Constants<S>::Inertia& inertia, const NodeState<S>& s) {
  return {inertia_force<S>(inertia, s), times(inertia.second_moment, s.angular_acceleration) +
                                            gyroscopic(s.angular_velocity, inertia.second_moment) +
                                            cross(inertia.first_moment, s.acceleration)};
}

template <class S>
inline void add_inertia_wrench(const typename Constants<S>::Inertia& inertia, const NodeState<S>& s,
                               Wrench<S>& wrench) {
  const Wrench<S> own = inertia_wrench(inertia, s);
  wrench.force += own.force;
  wrench.moment += own.moment;
}

/// Adds a node's wrench, seen from its parent, to the parent's.
template <class S>
inline void propagate_to_parent(const NodeState<S>& s, const Wrench<S>& wrench, Wrench<S>& parent) {
  const typename S::Vector force = s.R_PN * wrench.force;
  parent.force += force;
  parent.moment += s.R_PN * wrench.moment + cross(s.p_PN, force);
}

/// The node's wrench along its own motion.
template <class S>
inline typename S::Scalar project_on_joint_axis(const Node<Constants<S>>& node, const Wrench<S>& wrench) {
  return node.ratio *
         (node.motion == NodeMotion::revolute ? axis_component(wrench.moment) : slide_component(wrench.force));
}

/// @param wrenches on entry what the surroundings do not supply (minus the external wrenches), on return what every node's
///        parent exerts; wrenches[0]: what the ground exerts on everything, world axes, about the world's origin
/// @param tau generalised forces per tree coordinate [N m or N]
template <class S>
void inverse_dynamics(const Tree<Constants<S>>& tree, const TreeState<S>& state, std::vector<Wrench<S>>& wrenches,
                      typename S::Scalar* tau) {
  for (int c = 0; c < tree.columns; ++c) tau[c] = 0;
  for (std::size_t n = tree.nodes.size(); n-- > 1;) {
    const Node<Constants<S>>& node = tree.nodes[n];
    Wrench<S> wrench = wrenches[n];  // worked on in registers
    if (!node.massless) add_inertia_wrench<S>(node.inertia, state[n], wrench);
    wrenches[n] = wrench;
    if (node.motion != NodeMotion::weld) tau[node.column] += project_on_joint_axis(node, wrench);
    propagate_to_parent(state[n], wrench, wrenches[node.parent]);
  }
}

/// Generalised forces of the wrenches alone, as if nothing had mass. Arguments as in inverse_dynamics.
template <class S>
void compute_wrench_forces(const Tree<Constants<S>>& tree, const TreeState<S>& state, std::vector<Wrench<S>>& wrenches,
                           typename S::Scalar* tau) {
  for (int c = 0; c < tree.columns; ++c) tau[c] = 0;
  for (std::size_t n = tree.nodes.size(); n-- > 1;) {
    const Node<Constants<S>>& node = tree.nodes[n];
    if (node.motion != NodeMotion::weld) tau[node.column] += project_on_joint_axis(node, wrenches[n]);
    propagate_to_parent(state[n], wrenches[n], wrenches[node.parent]);
  }
}

/// Generalised forces of an open tree without external forces, the shortest way to the torques of a serial arm: sines and cosines, of
/// which none waits for another, then in one go outwards and one back. What the ground exerts is not asked for: wrenches[0] is left as it is.
template <class S>
void open_tree_inverse_dynamics(const Tree<Constants<S>>& tree, const typename S::Scalar* y,
                                const typename S::Scalar* dy, const typename S::Scalar* ddy,
                                const typename S::Vector& gravity, TreeState<S>& state,
                                std::vector<Wrench<S>>& wrenches, typename S::Scalar* tau) {
  state[0].acceleration = -gravity;
  for (int c = 0; c < tree.columns; ++c) tau[c] = 0;
  set_local_poses(tree, y, state);
  for (std::size_t n = 1; n < tree.nodes.size(); ++n) {
    const Node<Constants<S>>& node = tree.nodes[n];
    const NodeState<S>& parent = state[node.parent];
    set_angular_velocity(node, dy, parent, state[n]);
    set_acceleration(node, dy, ddy, parent, state[n]);
    wrenches[n] = node.massless ? Wrench<S>() : inertia_wrench<S>(node.inertia, state[n]);
  }
  for (std::size_t n = tree.nodes.size(); n-- > 1;) {
    const Node<Constants<S>>& node = tree.nodes[n];
    if (node.motion != NodeMotion::weld) tau[node.column] += project_on_joint_axis(node, wrenches[n]);
    if (node.parent > 0) propagate_to_parent(state[n], wrenches[n], wrenches[node.parent]);
  }
}

}  // namespace balance
