#pragma once
/// Loops that would lose rank on their own where others keep the motion determinate. Private to motion.

#include "balance/kinematics/state.hpp"
#include "balance/model/simple_loops.hpp"

#include <string>
#include <vector>

namespace balance {

template <class S>
class LoopRankMonitor {
 public:
  /// @param mechanism, tree must outlive it
  LoopRankMonitor(const Mechanism& mechanism, const Tree<S>& tree);

  std::size_t loop_count() const { return loops_.size(); }
  /// "A, B, C, D": the joints along a loop.
  std::string joint_names(std::size_t loop) const;

  /// Singular values, largest first, of what a loop's joints let its bodies do against each other: as many as equations of closure,
  /// angles and characteristic lengths.
  /// @param poses of the tree's nodes
  VectorX singular_values(std::size_t loop, const TreeState<S>& poses) const;

 private:
  void add_joint_twists(const LoopStep& step, const TreeState<S>& poses, const typename S::Vector& about,
                        MatrixX& twists) const;

  const Mechanism& mechanism_;
  const Tree<S>& tree_;
  std::vector<SimpleLoop> loops_;
};

extern template class LoopRankMonitor<Planar>;
extern template class LoopRankMonitor<Spatial>;

}  // namespace balance
