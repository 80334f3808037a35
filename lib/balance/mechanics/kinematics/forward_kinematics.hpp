#pragma once
/// Poses, velocities and accelerations of all nodes, by one recursion from the ground outwards (Featherstone, Rigid
/// Body Dynamics Algorithms, 2008, ch. 4–5, with two three-vectors per body instead of one spatial vector).

#include "balance/foundation/base/pack.hpp"
#include "balance/mechanics/kinematics/tree.hpp"

#include <cmath>
#include <type_traits>
#include <vector>

namespace balance::kinematics {

/// Motion of a node N. Quantities without W in their name are in N's own axes.
template <class S>
struct alignas(storage_alignment<typename S::Scalar>) NodeState {
  typename S::Rotation R_PN;  ///< in the parent's axes
  typename S::Vector p_PN = S::Vector::Zero();
  typename S::Rotation R_WN;  ///< in the world
  typename S::Vector p_WN = S::Vector::Zero();
  typename S::Angular angular_velocity = S::zero_angular();
  typename S::Vector velocity = S::Vector::Zero();  ///< of N's origin
  typename S::Angular angular_acceleration = S::zero_angular();
  typename S::Vector acceleration =
      S::Vector::Zero();  ///< of N's origin; gravity is subtracted if the base acceleration was −g
  typename S::AccelerationOperator acceleration_operator =
      S::zero_acceleration_operator();  ///< from the angular velocity and acceleration
};

template <class S>
using TreeState = std::vector<NodeState<S>>;

template <class S>
inline void set_revolute_pose(const Node<Constants<S>>& node, const typename S::Scalar& cosine,
                              const typename S::Scalar& sine, NodeState<S>& state) {
  state.R_PN = rotate_about_joint_axis(node.R_PF, cosine, sine);
  state.p_PN = node.p_PF.template cast<typename S::Scalar>();
}

/// Pose of the node relative to its parent at y.
template <class S>
inline void set_local_pose(const Node<Constants<S>>& node, const typename S::Scalar* y, NodeState<S>& state) {
  using T = typename S::Scalar;
  switch (node.motion) {
    case NodeMotion::revolute: {
      const T x = node.ratio * y[node.column] + node.offset;
      T s, c;
      sine_cosine_into(x, s, c);
      set_revolute_pose(node, c, s, state);
      break;
    }
    case NodeMotion::prismatic:
      state.R_PN = cast<T>(node.R_PF);
      state.p_PN = node.p_PF + (node.ratio * y[node.column] + node.offset) * prismatic_axis(node.R_PF);
      break;
    case NodeMotion::weld:
      state.R_PN = cast<T>(node.R_PF);
      state.p_PN = node.p_PF.template cast<T>();
      break;
  }
}

template <class S>
void set_local_poses(const Tree<Constants<S>>& tree, const typename S::Scalar* y, TreeState<S>& state) {
  for (std::size_t n = 1; n < tree.nodes.size(); ++n) set_local_pose(tree.nodes[n], y, state[n]);
}

/// For a single motion, evaluates the rotations in pairs, which keeps the processor busier. The results are bitwise
/// identical.
template <class S>
requires std::is_same_v<typename S::Scalar, double>
void set_local_poses(const Tree<S>& tree, const double* y, TreeState<S>& state) {
  const auto angle = [&](const Node<S>& node) { return node.ratio * y[node.column] + node.offset; };
  std::size_t pending_node = 0;  // first node of a pair; 0: none
  for (std::size_t n = 1; n < tree.nodes.size(); ++n) {
    const Node<S>& node = tree.nodes[n];
    if (node.motion != NodeMotion::revolute) {
      set_local_pose(node, y, state[n]);
    } else if (pending_node == 0) {
      pending_node = n;
    } else {
      const Node<S>& first = tree.nodes[pending_node];
      const auto pair = sine_cosine(Pack<2>(Pack<2>::Numbers{angle(first), angle(node)}));
      set_revolute_pose(first, pair.cosine[0], pair.sine[0], state[pending_node]);
      set_revolute_pose(node, pair.cosine[1], pair.sine[1], state[n]);
      pending_node = 0;
    }
  }
  if (pending_node > 0) set_local_pose(tree.nodes[pending_node], y, state[pending_node]);
}

template <class S>
inline void set_world_pose(const NodeState<S>& parent, NodeState<S>& state) {
  state.R_WN = parent.R_WN * state.R_PN;
  state.p_WN = parent.p_WN + parent.R_WN * state.p_PN;
}

/// Angular velocity only, which is all that forces need.
template <class S>
inline void set_angular_velocity(const Node<Constants<S>>& node, const typename S::Scalar* dy,
                                 const NodeState<S>& parent, NodeState<S>& state) {
  state.angular_velocity =  // the ground does not rotate
      node.parent == 0 ? S::zero_angular() : typename S::Angular(rotate_inverse(state.R_PN, parent.angular_velocity));
  if (node.motion == NodeMotion::revolute) add_to_axis_component(state.angular_velocity, node.ratio * dy[node.column]);
}

template <class S>
inline void set_velocity(const Node<Constants<S>>& node, const typename S::Scalar* dy, const NodeState<S>& parent,
                         NodeState<S>& state) {
  state.velocity =
      rotate_inverse(state.R_PN, typename S::Vector(parent.velocity + cross(parent.angular_velocity, state.p_PN)));
  if (node.motion == NodeMotion::prismatic) add_to_slide_component(state.velocity, node.ratio * dy[node.column]);
}

/// Acceleration of a point fixed to a node, in node axes.
template <class S, class Vector>
inline typename S::Vector local_point_acceleration(const NodeState<S>& state, const Vector& p_N) {
  return state.acceleration + times(state.acceleration_operator, p_N);
}

/// @param ddy null: only the velocity-product accelerations
template <class S>
inline void set_acceleration(const Node<Constants<S>>& node, const typename S::Scalar* dy,
                             const typename S::Scalar* ddy, const NodeState<S>& parent, NodeState<S>& state) {
  typename S::Vector a = parent.acceleration;  // kept in registers
  typename S::Angular alpha = S::zero_angular();
  if (node.parent > 0) {  // the ground does not rotate
    a = local_point_acceleration(parent, state.p_PN);
    alpha = rotate_inverse(state.R_PN, parent.angular_acceleration);
  }
  a = rotate_inverse(state.R_PN, a);
  if (node.motion == NodeMotion::revolute) {
    alpha += cross_with_axis(state.angular_velocity, typename S::Scalar(node.ratio * dy[node.column]));
    if (ddy) add_to_axis_component(alpha, typename S::Scalar(node.ratio * ddy[node.column]));
  } else if (node.motion == NodeMotion::prismatic) {
    const typename S::Vector relative_velocity = node.ratio * dy[node.column] * S::slide_direction();
    a += 2 * cross(state.angular_velocity, relative_velocity);
    if (ddy) add_to_slide_component(a, typename S::Scalar(node.ratio * ddy[node.column]));
  }
  state.acceleration = a;
  state.angular_acceleration = alpha;
  state.acceleration_operator = make_acceleration_operator(state.angular_velocity, alpha);
}

template <class S>
void compute_poses(const Tree<Constants<S>>& tree, const typename S::Scalar* y, TreeState<S>& state) {
  set_local_poses(tree, y, state);
  for (std::size_t n = 1; n < tree.nodes.size(); ++n) set_world_pose(state[tree.nodes[n].parent], state[n]);
}

template <class S>
void compute_angular_velocities(const Tree<Constants<S>>& tree, const typename S::Scalar* dy, TreeState<S>& state) {
  for (std::size_t n = 1; n < tree.nodes.size(); ++n)
    set_angular_velocity(tree.nodes[n], dy, state[tree.nodes[n].parent], state[n]);
}

/// Velocities of the nodes' origins. @pre the angular velocities are known
template <class S>
void compute_origin_velocities(const Tree<Constants<S>>& tree, const typename S::Scalar* dy, TreeState<S>& state) {
  for (std::size_t n = 1; n < tree.nodes.size(); ++n)
    set_velocity(tree.nodes[n], dy, state[tree.nodes[n].parent], state[n]);
}

template <class S>
void compute_velocities(const Tree<Constants<S>>& tree, const typename S::Scalar* dy, TreeState<S>& state) {
  compute_angular_velocities(tree, dy, state);
  compute_origin_velocities(tree, dy, state);
}

/// @param base acceleration of the ground; −gravity makes weight part of the inertia forces
template <class S>
void compute_accelerations(const Tree<Constants<S>>& tree, const typename S::Scalar* dy, const typename S::Scalar* ddy,
                           const typename S::Vector& base, TreeState<S>& state) {
  state[0].acceleration = base;
  for (std::size_t n = 1; n < tree.nodes.size(); ++n)
    set_acceleration(tree.nodes[n], dy, ddy, state[tree.nodes[n].parent], state[n]);
}

/// World pose of a frame fixed to a node.
template <class S>
inline typename S::Vector position(const TreeState<S>& state, const FixedFrame<Constants<S>>& frame) {
  return state[frame.node].p_WN + state[frame.node].R_WN * frame.p_N;
}
template <class S>
inline typename S::Rotation orientation(const TreeState<S>& state, const FixedFrame<Constants<S>>& frame) {
  return state[frame.node].R_WN * frame.R_N;
}

/// World velocity of a point fixed to a node.
template <class S, class Vector>
inline typename S::Vector point_velocity(const NodeState<S>& state, const Vector& p_N) {
  return state.R_WN * typename S::Vector(state.velocity + cross(state.angular_velocity, p_N));
}

/// World acceleration of a point fixed to a node (minus gravity if the base acceleration was −g).
template <class S, class Vector>
inline typename S::Vector point_acceleration(const NodeState<S>& state, const Vector& p_N) {
  return state.R_WN * local_point_acceleration(state, p_N);
}

/// Rate of a node's linear momentum, in node axes.
template <class S>
inline typename S::Vector inertia_force(const typename Constants<S>::Inertia& inertia, const NodeState<S>& state) {
  return inertia.mass * state.acceleration + times(state.acceleration_operator, inertia.first_moment);
}

}  // namespace balance::kinematics
