#pragma once
/// What a tree's nodes carry while payloads come and go.

#include "balance/mechanics/kinematics/tree.hpp"
#include "balance/mechanics/model/payload_intervals.hpp"

#include <cstddef>
#include <utility>
#include <vector>

namespace balance {

template <class S>
class TreePayloads {
 public:
  /// @param tree compiled of the mechanism, with everything there
  /// @param duration of the motion, which begins at time 0 [s]
  TreePayloads(const MechanismOf<typename S::Scalar>& mechanism, const Tree<S>& tree, double duration)
      : stretches_(mechanism, duration),
        first_(mechanism.bodies.size() - 1),
        attachments_(mechanism.attachments.size()) {
    if (!has_temporary_payloads(mechanism)) return;
    for (int k = 0; k < stretches_.count(); ++k) loads_.push_back(sum_inertias(tree, k));
  }

  const PayloadIntervals& intervals() const { return stretches_; }
  /// The stretch whose inertias were given last; −1: none yet.
  int current_interval() const { return now_; }

  /// Whether an element of the tree (Tree::elements) is there in a stretch.
  bool is_attached(std::size_t element, int stretch) const {
    const bool attached = element >= first_ && element < first_ + attachments_;
    return !attached || stretches_.is_attached(element - first_, stretch);
  }

  /// Gives the nodes the inertia of what is there from a time on; only masses of the tree change.
  /// @return false if they have it already
  bool apply(double time, Tree<S>& tree) {
    const int stretch = stretches_.index_at(time);
    if (stretch == now_) return false;
    now_ = stretch;
    if (loads_.empty()) return false;
    const NodeInertias& load = loads_[static_cast<std::size_t>(stretch)];
    for (std::size_t n = 0; n < tree.nodes.size(); ++n) tree.nodes[n].inertia = load.inertias[n];
    tree.mass = load.mass;
    return true;
  }

 private:
  struct NodeInertias {
    std::vector<typename S::Inertia> inertias;  ///< per node
    typename S::Scalar mass = 0;
  };

  /// As compile_tree() adds them, in the same order, so that a mechanism without what is not there has the same numbers.
  NodeInertias sum_inertias(const Tree<S>& tree, int stretch) const {
    NodeInertias load;
    load.inertias.resize(tree.nodes.size(), Node<S>().inertia);
    for (std::size_t e = 0; e < tree.mass_elements.size(); ++e) {
      const MassElement<S>& element = tree.mass_elements[e];
      if (element.frame.node == 0 || !is_attached(e, stretch)) continue;
      const typename S::Inertia added = transform_inertia<S>(element.inertia, element.frame.R_N, element.frame.p_N);
      typename S::Inertia& inertia = load.inertias[static_cast<std::size_t>(element.frame.node)];
      load.mass += element.inertia.mass;
      inertia.mass += added.mass;
      inertia.first_moment += added.first_moment;
      inertia.second_moment += added.second_moment;
    }
    return load;
  }

  PayloadIntervals stretches_;
  std::size_t first_, attachments_;  ///< where attachments begin among the elements, and how many there are
  std::vector<NodeInertias> loads_;  ///< per stretch; empty: nothing comes or goes
  int now_ = -1;
};

}  // namespace balance
