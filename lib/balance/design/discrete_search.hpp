#pragma once
/// One walk through the branches of a design problem with sizes and choices. Private to design.

#include "balance/design/discrete_bounds.hpp"
#include "balance/design/solve.hpp"

namespace balance::design {

/// A figure may be above its bound by this part, which is round-off of the convex problem.
inline constexpr double relative_gap_tolerance = 1e-6;

/// A design with all sizes decided.
struct DiscreteCandidate {
  enum class Rank { exact, limits_violated, conditions_violated };
  Rank rank = Rank::conditions_violated;
  double value =
      0;  ///< the figure; by how much limits are missed; what is left of the conditions, or the figure of those
  DesignOutcome outcome;
};

struct BranchAndBoundResult {
  std::optional<DiscreteCandidate> incumbent;
  bool is_exhausted = true;  ///< if none was found that was wanted, there is none
  double lower_bound =
      std::numeric_limits<double>::infinity();  ///< no design that was wanted is below it, found or not
};

/// What all walks of a design have spent.
struct NodeCounts {
  int branches = 0, designs = 0;
};

class BranchAndBound {
 public:
  BranchAndBound(const DesignProblem& problem, SearchBudget& budget, NodeBounds& bounds, NodeCounts& steps)
      : problem_(problem), budget_(budget), bounds_(bounds), steps_(steps) {}

  BranchAndBoundResult run(const BranchingRule& branching, BranchObjective wanted);

 private:
  void process_node(const BranchingRule& branching, BranchNode branch);
  void solve_leaf(const BranchNode& branch, double least, bool bounded);
  double leaf_bound(const BranchNode& branch, double least, const std::optional<DiscreteCandidate>& design,
                    const DesignOutcome& outcome) const;
  std::optional<DiscreteCandidate> rate(DesignOutcome outcome) const;
  bool is_done() const;

  const DesignProblem& problem_;
  SearchBudget& budget_;
  NodeBounds& bounds_;
  NodeCounts& steps_;
  BranchObjective wanted_ = BranchObjective::constrained_figure;
  std::vector<BranchNode> open_;  ///< the next one last
  BranchAndBoundResult walk_;
};

}  // namespace balance::design
