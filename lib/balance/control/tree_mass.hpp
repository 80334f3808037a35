#pragma once
/// The tree's mass matrix by the composite-rigid-body algorithm (Featherstone, Rigid Body Dynamics Algorithms, 2008, table 6.2):
/// what a node carries moves as one rigid body when only that node's coordinate changes. Private to control.

#include "balance/dynamics/recursion.hpp"

#include <vector>

namespace balance {

inline Planar::Inertia transform_to_parent(const Planar::Inertia& inertia, const NodeState<Planar>& s) {
  const Vector2 moment = s.R_PN * inertia.first_moment;
  return {inertia.mass, moment + inertia.mass * s.p_PN,
          inertia.second_moment + 2 * dot(s.p_PN, moment) + inertia.mass * dot(s.p_PN, s.p_PN)};
}

inline Spatial::Inertia transform_to_parent(const Spatial::Inertia& inertia, const NodeState<Spatial>& s) {
  return transform_inertia<Spatial>(inertia, s.R_PN, s.p_PN);
}

/// What gives everything that a node carries a unit acceleration along the node's own motion: node axes, about its origin.
inline Wrench<Planar> unit_acceleration_wrench(const Planar::Inertia& inertia, NodeMotion motion) {
  if (motion == NodeMotion::revolute)
    return {{-inertia.first_moment.y(), inertia.first_moment.x()}, inertia.second_moment};
  return {{inertia.mass, 0}, -inertia.first_moment.y()};
}

inline Wrench<Spatial> unit_acceleration_wrench(const Spatial::Inertia& inertia, NodeMotion motion) {
  const Vector3& c = inertia.first_moment;
  if (motion == NodeMotion::revolute) return {{-c.y(), c.x(), 0}, inertia.second_moment.col(2)};
  return {{0, 0, inertia.mass}, {c.y(), -c.x(), 0}};
}

template <class S>
class CompositeRigidBodies {
 public:
  explicit CompositeRigidBodies(const Tree<S>& tree)
      : composite_(tree.nodes.size()), has_mass_(tree.nodes.size(), false) {
    for (std::size_t n = tree.nodes.size(); n-- > 1;) {
      if (!tree.nodes[n].massless) has_mass_[n] = true;
      if (has_mass_[n]) has_mass_[tree.nodes[n].parent] = true;
    }
  }

  /// @param state poses in the parents
  /// @param matrix n×n, symmetric
  void compute_mass_matrix(const Tree<S>& tree, const TreeState<S>& state, double* matrix) {
    const int columns = tree.columns;
    for (int k = 0; k < columns * columns; ++k) matrix[k] = 0;
    const std::size_t nodes = tree.nodes.size();
    for (std::size_t n = 1; n < nodes; ++n) composite_[n] = tree.nodes[n].inertia;
    for (std::size_t n = nodes; n-- > 1;) {
      if (!has_mass_[n]) continue;
      const Node<S>& node = tree.nodes[n];
      if (node.motion != NodeMotion::weld) add_couplings(tree, state, static_cast<int>(n), matrix);
      if (node.parent == 0) continue;
      const typename S::Inertia seen = transform_to_parent(composite_[n], state[n]);
      typename S::Inertia& parent = composite_[node.parent];
      parent.mass += seen.mass;
      parent.first_moment += seen.first_moment;
      parent.second_moment += seen.second_moment;
    }
  }

 private:
  /// The node's own entry, and those with every node that carries it.
  void add_couplings(const Tree<S>& tree, const TreeState<S>& state, int n, double* matrix) const {
    const int columns = tree.columns, column = tree.nodes[n].column;
    const double ratio = tree.nodes[n].ratio;
    Wrench<S> wrench = unit_acceleration_wrench(composite_[n], tree.nodes[n].motion);
    matrix[column * columns + column] += ratio * project_on_joint_axis(tree.nodes[n], wrench);
    for (int child = n, at = tree.nodes[n].parent; at > 0; child = at, at = tree.nodes[at].parent) {
      Wrench<S> seen;
      propagate_to_parent(state[child], wrench, seen);
      wrench = seen;
      const Node<S>& node = tree.nodes[at];
      if (node.motion == NodeMotion::weld) continue;
      const double value = ratio * project_on_joint_axis(node, wrench);
      // both orders; where one coordinate moves both nodes they meet in one entry
      matrix[column * columns + node.column] += value;
      matrix[node.column * columns + column] += value;
    }
  }

  std::vector<typename S::Inertia> composite_;
  std::vector<bool> has_mass_;  ///< the node or something on it has mass
};

}  // namespace balance
