#pragma once
/// Loops that would lose rank on their own where others keep the motion determinate. Private to motion.

#include "balance/kinematics/state.hpp"
#include "balance/model/simple_loops.hpp"

#include <string>
#include <vector>

namespace balance {

template <class S>
class LoopRanks {
 public:
  /// @param mechanism, tree must outlive it
  LoopRanks(const Mechanism& mechanism, const Tree<S>& tree);

  std::size_t loops() const { return loops_.size(); }
  /// "A, B, C, D": the joints along a loop.
  std::string joints(std::size_t loop) const;

  /// Singular values, largest first, of what a loop's joints let its bodies do against each other: as many as equations of closure,
  /// angles and characteristic lengths.
  /// @param poses of the tree's nodes
  VectorX strengths(std::size_t loop, const State<S>& poses) const;

 private:
  void add_joint(const LoopStep& step, const State<S>& poses, const typename S::Vector& about, MatrixX& twists) const;

  const Mechanism& mechanism_;
  const Tree<S>& tree_;
  std::vector<SimpleLoop> loops_;
};

extern template class LoopRanks<Planar>;
extern template class LoopRanks<Spatial>;

}  // namespace balance
