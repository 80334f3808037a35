#pragma once
/// Inertias of a tree's nodes while payloads are attached and detached.

#include "balance/mechanics/kinematics/tree.hpp"
#include "balance/mechanics/model/payload_intervals.hpp"

#include <cstddef>
#include <utility>
#include <vector>

namespace balance::kinematics {

template <class S>
class TreePayloads {
 public:
  /// @param tree compiled from the mechanism with all payloads attached
  /// @param duration of the motion, which begins at time 0 [s]
  TreePayloads(const MechanismOf<typename S::Scalar>& mechanism, const Tree<S>& tree, double duration)
      : intervals_(mechanism, duration),
        first_attachment_(mechanism.bodies.size() - 1),
        attachment_count_(mechanism.attachments.size()) {
    if (!has_temporary_payloads(mechanism)) return;
    for (int k = 0; k < intervals_.count(); ++k) inertias_per_interval_.push_back(sum_inertias(tree, k));
  }

  const model::PayloadIntervals& intervals() const { return intervals_; }
  /// The interval whose inertias were applied last; −1: none yet.
  int current_interval() const { return current_interval_; }

  /// Whether a mass element of the tree (Tree::mass_elements) is attached in an interval.
  bool is_attached(std::size_t element, int interval) const {
    const bool attached = element >= first_attachment_ && element < first_attachment_ + attachment_count_;
    return !attached || intervals_.is_attached(element - first_attachment_, interval);
  }

  /// Sets the nodes' inertias to those that hold from a time on. Only inertias and the total mass of the tree change.
  /// @return false if nothing changes
  bool apply(double time, Tree<S>& tree) {
    const int interval = intervals_.index_at(time);
    if (interval == current_interval_) return false;
    current_interval_ = interval;
    if (inertias_per_interval_.empty()) return false;
    const NodeInertias& node_inertias = inertias_per_interval_[static_cast<std::size_t>(interval)];
    for (std::size_t n = 0; n < tree.nodes.size(); ++n) tree.nodes[n].inertia = node_inertias.inertias[n];
    tree.mass = node_inertias.mass;
    return true;
  }

 private:
  struct NodeInertias {
    std::vector<typename S::Inertia> inertias;  ///< per node
    typename S::Scalar mass = 0;
  };

  /// Sums in the same order as compile_tree(), so that the numbers equal those of a mechanism without the absent
  /// payloads.
  NodeInertias sum_inertias(const Tree<S>& tree, int interval) const {
    NodeInertias node_inertias;
    node_inertias.inertias.resize(tree.nodes.size(), Node<S>().inertia);
    for (std::size_t e = 0; e < tree.mass_elements.size(); ++e) {
      const MassElement<S>& element = tree.mass_elements[e];
      if (element.frame.node == 0 || !is_attached(e, interval)) continue;
      const typename S::Inertia added = transform_inertia<S>(element.inertia, element.frame.R_N, element.frame.p_N);
      typename S::Inertia& inertia = node_inertias.inertias[static_cast<std::size_t>(element.frame.node)];
      node_inertias.mass += element.inertia.mass;
      inertia.mass += added.mass;
      inertia.first_moment += added.first_moment;
      inertia.second_moment += added.second_moment;
    }
    return node_inertias;
  }

  model::PayloadIntervals intervals_;
  std::size_t first_attachment_,
      attachment_count_;  ///< index of the first attachment among the elements; number of attachments
  std::vector<NodeInertias> inertias_per_interval_;  ///< per interval; empty: no temporary payloads
  int current_interval_ = -1;
};

}  // namespace balance::kinematics
