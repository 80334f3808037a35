#pragma once
/// Inverse dynamics of the tree: recursive Newton–Euler from the leaves to the ground (Featherstone, Rigid Body
/// Dynamics Algorithms, 2008, table 5.1).

#include "balance/mechanics/kinematics/forward_kinematics.hpp"

#include <vector>

namespace balance::dynamics {

/// Wrench that a node's parent exerts on the node and everything it carries: node axes, moment about the node's origin.
template <class S>
struct alignas(storage_alignment<typename S::Scalar>) Wrench {
  typename S::Vector force = S::Vector::Zero();
  typename S::Angular moment = S::zero_angular();
};

/// Force and moment that give one node its acceleration.
template <class S>
inline Wrench<S> inertia_wrench(const typename kinematics::Constants<S>::Inertia& inertia,
                                const kinematics::NodeState<S>& s) {
  return {kinematics::inertia_force<S>(inertia, s),
          kinematics::times(inertia.second_moment, s.angular_acceleration) +
              kinematics::gyroscopic(s.angular_velocity, inertia.second_moment) +
              kinematics::cross(inertia.first_moment, s.acceleration)};
}

template <class S>
inline void add_inertia_wrench(const typename kinematics::Constants<S>::Inertia& inertia,
                               const kinematics::NodeState<S>& s, Wrench<S>& wrench) {
  const Wrench<S> inertial = inertia_wrench(inertia, s);
  wrench.force += inertial.force;
  wrench.moment += inertial.moment;
}

/// Adds a node's wrench, seen from its parent, to the parent's.
template <class S>
inline void propagate_to_parent(const kinematics::NodeState<S>& s, const Wrench<S>& wrench, Wrench<S>& parent) {
  const typename S::Vector force = s.R_PN * wrench.force;
  parent.force += force;
  parent.moment += s.R_PN * wrench.moment + kinematics::cross(s.p_PN, force);
}

/// Component of the node's wrench along its own motion.
template <class S>
inline typename S::Scalar project_on_joint_axis(const kinematics::Node<kinematics::Constants<S>>& node,
                                                const Wrench<S>& wrench) {
  return node.ratio * (node.motion == kinematics::NodeMotion::revolute ? kinematics::axis_component(wrench.moment)
                                                                       : kinematics::slide_component(wrench.force));
}

/// @param wrenches on entry minus the external wrenches, on return those that every node's parent exerts; wrenches[0]:
///        that of the ground on everything, world axes, about the world's origin
/// @param tau generalised forces per tree coordinate [N m or N]
template <class S>
void inverse_dynamics(const kinematics::Tree<kinematics::Constants<S>>& tree, const kinematics::TreeState<S>& state,
                      std::vector<Wrench<S>>& wrenches, typename S::Scalar* tau) {
  for (int c = 0; c < tree.columns; ++c) tau[c] = 0;
  for (std::size_t n = tree.nodes.size(); n-- > 1;) {
    const kinematics::Node<kinematics::Constants<S>>& node = tree.nodes[n];
    Wrench<S> wrench = wrenches[n];  // kept in registers
    if (!node.massless) add_inertia_wrench<S>(node.inertia, state[n], wrench);
    wrenches[n] = wrench;
    if (node.motion != kinematics::NodeMotion::weld) tau[node.column] += project_on_joint_axis(node, wrench);
    propagate_to_parent(state[n], wrench, wrenches[node.parent]);
  }
}

/// Generalised forces of the wrenches alone, as if nothing had mass. Arguments as in inverse_dynamics.
template <class S>
void compute_wrench_forces(const kinematics::Tree<kinematics::Constants<S>>& tree,
                           const kinematics::TreeState<S>& state, std::vector<Wrench<S>>& wrenches,
                           typename S::Scalar* tau) {
  for (int c = 0; c < tree.columns; ++c) tau[c] = 0;
  for (std::size_t n = tree.nodes.size(); n-- > 1;) {
    const kinematics::Node<kinematics::Constants<S>>& node = tree.nodes[n];
    if (node.motion != kinematics::NodeMotion::weld) tau[node.column] += project_on_joint_axis(node, wrenches[n]);
    propagate_to_parent(state[n], wrenches[n], wrenches[node.parent]);
  }
}

/// Generalised forces of an open tree without external forces, the fastest way to the torques of a serial arm: first
/// all sines and cosines, which are independent of each other, then one pass outwards and one back. The ground's wrench
/// is not computed: wrenches[0] stays unchanged.
template <class S>
void open_tree_inverse_dynamics(const kinematics::Tree<kinematics::Constants<S>>& tree, const typename S::Scalar* y,
                                const typename S::Scalar* dy, const typename S::Scalar* ddy,
                                const typename S::Vector& gravity, kinematics::TreeState<S>& state,
                                std::vector<Wrench<S>>& wrenches, typename S::Scalar* tau) {
  state[0].acceleration = -gravity;
  for (int c = 0; c < tree.columns; ++c) tau[c] = 0;
  set_local_poses(tree, y, state);
  for (std::size_t n = 1; n < tree.nodes.size(); ++n) {
    const kinematics::Node<kinematics::Constants<S>>& node = tree.nodes[n];
    const kinematics::NodeState<S>& parent = state[node.parent];
    set_angular_velocity(node, dy, parent, state[n]);
    set_acceleration(node, dy, ddy, parent, state[n]);
    wrenches[n] = node.massless ? Wrench<S>() : inertia_wrench<S>(node.inertia, state[n]);
  }
  for (std::size_t n = tree.nodes.size(); n-- > 1;) {
    const kinematics::Node<kinematics::Constants<S>>& node = tree.nodes[n];
    if (node.motion != kinematics::NodeMotion::weld) tau[node.column] += project_on_joint_axis(node, wrenches[n]);
    if (node.parent > 0) propagate_to_parent(state[n], wrenches[n], wrenches[node.parent]);
  }
}

/// The tree's mass matrix by the composite-rigid-body algorithm (Featherstone, Rigid Body Dynamics Algorithms, 2008,
/// table 6.2): everything that a node carries moves as one rigid body if only that node's coordinate changes.
inline kinematics::Planar::Inertia transform_to_parent(const kinematics::Planar::Inertia& inertia,
                                                       const kinematics::NodeState<kinematics::Planar>& s) {
  const Vector2 moment = s.R_PN * inertia.first_moment;
  return {inertia.mass, moment + inertia.mass * s.p_PN,
          inertia.second_moment + 2 * kinematics::dot(s.p_PN, moment) + inertia.mass * kinematics::dot(s.p_PN, s.p_PN)};
}

inline kinematics::Spatial::Inertia transform_to_parent(const kinematics::Spatial::Inertia& inertia,
                                                        const kinematics::NodeState<kinematics::Spatial>& s) {
  return kinematics::transform_inertia<kinematics::Spatial>(inertia, s.R_PN, s.p_PN);
}

/// Wrench that gives everything that a node carries a unit acceleration along the node's own motion: node axes, about
/// its origin.
inline Wrench<kinematics::Planar> unit_acceleration_wrench(const kinematics::Planar::Inertia& inertia,
                                                           kinematics::NodeMotion motion) {
  if (motion == kinematics::NodeMotion::revolute)
    return {{-inertia.first_moment.y(), inertia.first_moment.x()}, inertia.second_moment};
  return {{inertia.mass, 0}, -inertia.first_moment.y()};
}

inline Wrench<kinematics::Spatial> unit_acceleration_wrench(const kinematics::Spatial::Inertia& inertia,
                                                            kinematics::NodeMotion motion) {
  const Vector3& c = inertia.first_moment;
  if (motion == kinematics::NodeMotion::revolute) return {{-c.y(), c.x(), 0}, inertia.second_moment.col(2)};
  return {{0, 0, inertia.mass}, {c.y(), -c.x(), 0}};
}

template <class S>
class CompositeRigidBodies {
 public:
  explicit CompositeRigidBodies(const kinematics::Tree<S>& tree)
      : composite_(tree.nodes.size()), has_mass_(tree.nodes.size(), false) {
    for (std::size_t n = tree.nodes.size(); n-- > 1;) {
      if (!tree.nodes[n].massless) has_mass_[n] = true;
      if (has_mass_[n]) has_mass_[tree.nodes[n].parent] = true;
    }
  }

  /// @param state poses relative to the parents
  void compute_mass_matrix(const kinematics::Tree<S>& tree, const kinematics::TreeState<S>& state, double* matrix) {
    const int columns = tree.columns;
    for (int k = 0; k < columns * columns; ++k) matrix[k] = 0;
    const std::size_t nodes = tree.nodes.size();
    for (std::size_t n = 1; n < nodes; ++n) composite_[n] = tree.nodes[n].inertia;
    for (std::size_t n = nodes; n-- > 1;) {
      if (!has_mass_[n]) continue;
      const kinematics::Node<S>& node = tree.nodes[n];
      if (node.motion != kinematics::NodeMotion::weld) add_couplings(tree, state, static_cast<int>(n), matrix);
      if (node.parent == 0) continue;
      const typename S::Inertia transformed = transform_to_parent(composite_[n], state[n]);
      typename S::Inertia& parent = composite_[node.parent];
      parent.mass += transformed.mass;
      parent.first_moment += transformed.first_moment;
      parent.second_moment += transformed.second_moment;
    }
  }

 private:
  /// The node's own entry, and those with every node that carries it.
  void add_couplings(const kinematics::Tree<S>& tree, const kinematics::TreeState<S>& state, int n,
                     double* matrix) const {
    const int columns = tree.columns, column = tree.nodes[n].column;
    const double ratio = tree.nodes[n].ratio;
    Wrench<S> wrench = unit_acceleration_wrench(composite_[n], tree.nodes[n].motion);
    matrix[column * columns + column] += ratio * project_on_joint_axis(tree.nodes[n], wrench);
    for (int child = n, ancestor = tree.nodes[n].parent; ancestor > 0;
         child = ancestor, ancestor = tree.nodes[ancestor].parent) {
      Wrench<S> parent_wrench;
      propagate_to_parent(state[child], wrench, parent_wrench);
      wrench = parent_wrench;
      const kinematics::Node<S>& node = tree.nodes[ancestor];
      if (node.motion == kinematics::NodeMotion::weld) continue;
      const double value = ratio * project_on_joint_axis(node, wrench);
      // both symmetric entries; they coincide if one coordinate moves both nodes
      matrix[column * columns + node.column] += value;
      matrix[node.column * columns + column] += value;
    }
  }

  std::vector<typename S::Inertia> composite_;
  std::vector<bool> has_mass_;  ///< the node or something that it carries has mass
};

}  // namespace balance::dynamics
