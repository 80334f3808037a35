#pragma once
/// The tree's mass matrix by the composite-rigid-body algorithm (Featherstone, Rigid Body Dynamics Algorithms, 2008, table 6.2):
/// what a node carries moves as one rigid body when only that node's coordinate changes. Private to control.

#include "balance/dynamics/recursion.hpp"

#include <vector>

namespace balance {

inline Planar::Inertia seen_from_parent(const Planar::Inertia& inertia, const NodeState<Planar>& s) {
  const Vector2 moment = s.R_PN * inertia.moment;
  return {inertia.mass, moment + inertia.mass * s.p_PN,
          inertia.second + 2 * dot(s.p_PN, moment) + inertia.mass * dot(s.p_PN, s.p_PN)};
}

inline Spatial::Inertia seen_from_parent(const Spatial::Inertia& inertia, const NodeState<Spatial>& s) {
  return moved<Spatial>(inertia, s.R_PN, s.p_PN);
}

/// What gives everything that a node carries a unit acceleration along the node's own motion: node axes, about its origin.
inline Wrench<Planar> unit_wrench(const Planar::Inertia& inertia, NodeMotion motion) {
  if (motion == NodeMotion::turn) return {{-inertia.moment.y(), inertia.moment.x()}, inertia.second};
  return {{inertia.mass, 0}, -inertia.moment.y()};
}

inline Wrench<Spatial> unit_wrench(const Spatial::Inertia& inertia, NodeMotion motion) {
  const Vector3& c = inertia.moment;
  if (motion == NodeMotion::turn) return {{-c.y(), c.x(), 0}, inertia.second.col(2)};
  return {{0, 0, inertia.mass}, {c.y(), -c.x(), 0}};
}

template <class S>
class TreeMass {
 public:
  explicit TreeMass(const Tree<S>& tree) : composite_(tree.nodes.size()), carries_(tree.nodes.size(), false) {
    for (std::size_t n = tree.nodes.size(); n-- > 1;) {
      if (!tree.nodes[n].massless) carries_[n] = true;
      if (carries_[n]) carries_[tree.nodes[n].parent] = true;
    }
  }

  /// @param state poses in the parents
  /// @param matrix n×n, symmetric
  void fill(const Tree<S>& tree, const State<S>& state, double* matrix) {
    const int columns = tree.columns;
    for (int k = 0; k < columns * columns; ++k) matrix[k] = 0;
    const std::size_t nodes = tree.nodes.size();
    for (std::size_t n = 1; n < nodes; ++n) composite_[n] = tree.nodes[n].inertia;
    for (std::size_t n = nodes; n-- > 1;) {
      if (!carries_[n]) continue;
      const Node<S>& node = tree.nodes[n];
      if (node.motion != NodeMotion::weld) add_couplings(tree, state, static_cast<int>(n), matrix);
      if (node.parent == 0) continue;
      const typename S::Inertia seen = seen_from_parent(composite_[n], state[n]);
      typename S::Inertia& parent = composite_[node.parent];
      parent.mass += seen.mass;
      parent.moment += seen.moment;
      parent.second += seen.second;
    }
  }

 private:
  /// The node's own entry, and those with every node that carries it.
  void add_couplings(const Tree<S>& tree, const State<S>& state, int n, double* matrix) const {
    const int columns = tree.columns, column = tree.nodes[n].column;
    const double ratio = tree.nodes[n].ratio;
    Wrench<S> wrench = unit_wrench(composite_[n], tree.nodes[n].motion);
    matrix[column * columns + column] += ratio * along_motion(tree.nodes[n], wrench);
    for (int child = n, at = tree.nodes[n].parent; at > 0; child = at, at = tree.nodes[at].parent) {
      Wrench<S> seen;
      pass_on(state[child], wrench, seen);
      wrench = seen;
      const Node<S>& node = tree.nodes[at];
      if (node.motion == NodeMotion::weld) continue;
      const double value = ratio * along_motion(node, wrench);
      // both orders; where one coordinate moves both nodes they meet in one entry
      matrix[column * columns + node.column] += value;
      matrix[node.column * columns + column] += value;
    }
  }

  std::vector<typename S::Inertia> composite_;
  std::vector<bool> carries_;  ///< the node or something on it has mass
};

}  // namespace balance
