#pragma once
/// Sizes and elements to choose among, decided one after the other.

#include "balance/synthesis/design/condition_equations.hpp"
#include "balance/synthesis/design/conic_relaxation.hpp"
#include "balance/synthesis/design/design_problem.hpp"
#include "balance/synthesis/design/solve_design.hpp"

#include <memory>

namespace balance::design {

/// Some of all designs.
struct BranchNode {
  enum class ElementState { undecided, kept, excluded };
  VectorX lower, upper;                      ///< of the numbers [SI]; of one with sizes: two of them, or one twice
  std::vector<ElementState> element_states;  ///< of the elements, choice by choice
  double lower_bound = -std::numeric_limits<double>::infinity();  ///< no wanted design in it is below
};

class BranchingRule {
 public:
  /// @param least how many elements may be kept of all choices that ask for as few as will do
  BranchingRule(const DesignProblem& problem, int least);

  BranchNode root() const;
  /// Carries on what follows from what is decided. @return false if nothing is left
  bool propagate(BranchNode& branch) const;
  /// Whatever the other numbers are, sizes and counts are right.
  bool is_leaf(const BranchNode& branch) const;
  /// Two or three parts that make up a branch that is not decided; the one to look at first stands last.
  /// @param x numbers that suit the branch if there were no sizes
  std::vector<BranchNode> branch(const BranchNode& branch, const VectorX& x) const;
  /// The branch as bounds, with what counts of elements say of their numbers.
  VariableDomain node_domain(const BranchNode& branch) const;
  /// Per choice and element: one of its numbers is not zero.
  std::vector<std::vector<bool>> kept_elements(const VectorX& x) const;

  /// How many elements there are to choose among without a number, and in all.
  static int count_unrestricted_elements(const DesignProblem& problem);

 private:
  struct Element {
    std::vector<int> numbers;
    std::size_t group;
  };
  bool propagate_values(BranchNode& branch) const;
  bool propagate_element(BranchNode& branch, std::size_t k) const;
  bool propagate_counts(BranchNode& branch) const;
  int count(const BranchNode& branch, std::size_t group, BranchNode::ElementState fate) const;
  /// How much of its range an element's numbers take up.
  double range_fraction(const Element& element, const VectorX& x) const;
  std::vector<BranchNode> branch_on_element(const BranchNode& branch, std::size_t k) const;
  std::vector<BranchNode> branch_on_value(const BranchNode& branch, int number, double at) const;

  const DesignProblem& problem_;
  std::vector<Element> elements_;
  std::vector<int> groups_;  ///< how many are kept at most
};

// What parts of a design problem with sizes and choices cannot be better than.

/// What a search among sizes looks for.
enum class BranchObjective {
  constrained_figure,  ///< designs that meet the conditions, of them the least figure
  figure,              ///< the least figure, whatever the conditions
  residual,            ///< the least that is left of the conditions
};

/// The problem within a branch, without sizes and choices.
/// @param seconds that its search may take
DesignProblem restrict_to_node(const DesignProblem& problem, const BranchNode& branch, double seconds);

class NodeBounds {
 public:
  explicit NodeBounds(const DesignProblem& problem) : problem_(problem) {}

  struct Bound {
    bool has_relaxation = false;  ///< there is a convex problem that says so
    bool is_feasible = true;      ///< false: the branch holds no such design
    double lower_bound =
        -std::numeric_limits<double>::infinity();  ///< no such design has a figure (what is left) below it
    VectorX x;                                     ///< numbers between the sizes that come near it; may be empty
  };
  /// Conditions of all designs, in one scale; null where they are not the same for all.
  const Conditions* shared_conditions(const BranchNode& root);
  Bound operator()(const BranchNode& branch, const VariableDomain& part, BranchObjective wanted);

 private:
  /// One geometry, and all that can be decided at it.
  struct GeometryRelaxation {
    GeometryRelaxation(const DesignProblem& whole, const BranchNode& branch);
    DesignProblem problem;
    SearchBudget budget;
    SolverContext context;
    Conditions conditions;
    std::optional<ConicRelaxation> relaxation;
    bool is_infeasible = false;  ///< a condition on parameters is not met, and no number changes it
    double fixed_residual = 0;   ///< what is left of conditions that no number changes
    VectorX outer;
  };
  const GeometryRelaxation* relaxation_at(const BranchNode& branch);
  void find_outer(const BranchNode& root);

  const DesignProblem& problem_;
  std::vector<int> outer_;  ///< numbers whose values must be decided first
  std::unique_ptr<const GeometryRelaxation> place_;
  bool tried_ = false;
};

// One walk through the branches of a design problem with sizes and choices.

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
