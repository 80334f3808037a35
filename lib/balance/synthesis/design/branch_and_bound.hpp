#pragma once
/// Branch and bound over discrete values and optional elements.

#include "balance/synthesis/design/all_different.hpp"
#include "balance/synthesis/design/condition_equations.hpp"
#include "balance/synthesis/design/conic_relaxation.hpp"
#include "balance/synthesis/design/design_problem.hpp"
#include "balance/synthesis/design/size_search.hpp"
#include "balance/synthesis/design/solution_analysis.hpp"
#include "balance/synthesis/design/solve_design.hpp"

#include <memory>

namespace balance::design {

/// A subset of all designs.
struct BranchNode {
  enum class ElementState { undecided, kept, excluded };
  VectorX lower, upper;                      ///< of the variables [SI]; if discrete: two of their values, or one twice
  std::vector<ElementState> element_states;  ///< of the elements, in the order of the choices
  double lower_bound = -std::numeric_limits<double>::infinity();  ///< of all wanted designs in the node
};

class BranchingRule {
 public:
  /// @param max_kept_elements maximum number of elements kept, of all choices that ask for the minimum number
  BranchingRule(const DesignProblem& problem, int max_kept_elements);

  BranchNode root() const;
  /// Applies all consequences of the decisions so far. @return false if the node is empty
  bool propagate(BranchNode& branch) const;
  /// Whether discrete values and counts are satisfied for all values of the other variables.
  bool is_leaf(const BranchNode& branch) const;
  /// Splits a node that is not a leaf into two or three parts; the one to process first is the last.
  /// @param x good values for the node without discreteness
  std::vector<BranchNode> branch(const BranchNode& branch, const VectorX& x) const;
  /// The designs with the elements and discrete values of x.
  BranchNode node_of(const VectorX& x) const;
  /// Leaves out one more element. @return false if the node excludes it already
  bool exclude(BranchNode& branch, std::size_t k) const;
  std::size_t element_count() const { return elements_.size(); }
  /// The part of the node without the undecided elements that x hardly uses; std::nullopt if it is no leaf.
  std::optional<BranchNode> leaf_at(const BranchNode& branch, const VectorX& x) const;
  /// The node as bounds, including what the counts of elements imply for their variables.
  VariableDomain node_domain(const BranchNode& branch) const;
  /// For each choice and element, whether one of its variables is not zero.
  std::vector<std::vector<bool>> kept_elements(const VectorX& x) const;

  /// Number of elements in the choices that do not specify a number.
  static int count_unrestricted_elements(const DesignProblem& problem);

 private:
  struct Element {
    std::vector<int> numbers, own_numbers;
    std::size_t group;
    bool must_be_decided;  ///< whether it decides which variables must differ
  };
  bool propagate_values(BranchNode& branch) const;
  bool propagate_element(BranchNode& branch, std::size_t k) const;
  void fix_excluded(BranchNode& branch, std::size_t k) const;
  bool propagate_counts(BranchNode& branch) const;
  bool is_open(const BranchNode& branch, std::size_t k) const;
  std::vector<bool> list_present(const BranchNode& branch) const;
  int count(const BranchNode& branch, std::size_t group, BranchNode::ElementState state) const;
  /// The maximum fraction of its range that a variable of the element uses.
  double range_fraction(const Element& element, const VectorX& x) const;
  std::vector<BranchNode> branch_on_element(const BranchNode& branch, std::size_t k) const;
  std::vector<BranchNode> branch_on_value(const BranchNode& branch, int number, double at) const;

  const DesignProblem& problem_;
  AllDifferent all_different_;
  std::vector<Element> elements_;
  std::vector<int> groups_;  ///< maximum number of kept elements
};

// Bounds for subsets of a design problem with discrete values and choices.

/// Target of a discrete search.
enum class BranchObjective {
  constrained_figure,  ///< minimum figure of the designs that meet the conditions
  figure,              ///< minimum figure, regardless of the conditions
  residual,            ///< minimum residual of the conditions
};

/// The problem within a node, without discrete values and choices.
/// @param seconds time limit of its search
DesignProblem restrict_to_node(const DesignProblem& problem, const BranchNode& branch, double seconds);

class NodeBounds {
 public:
  explicit NodeBounds(const DesignProblem& problem) : problem_(problem) {}

  struct Bound {
    bool has_relaxation = false;  ///< there is a convex relaxation
    bool is_feasible = true;      ///< false: the node contains no wanted design
    double lower_bound =
        -std::numeric_limits<double>::infinity();  ///< of the figure (or residual) of all wanted designs
    VectorX x;                                     ///< nearly attain the bound; perhaps not discrete; may be empty
  };
  /// Conditions of all designs, with the same scaling; nullptr if they differ.
  const Conditions* shared_conditions(const BranchNode& root);
  Bound operator()(const BranchNode& branch, const VariableDomain& domain, BranchObjective target);

 private:
  /// The relaxation at one geometry.
  struct GeometryRelaxation {
    GeometryRelaxation(const DesignProblem& full_problem, const BranchNode& branch);
    DesignProblem problem;
    SearchBudget budget;
    SolverContext context;
    Conditions conditions;
    std::optional<ConicRelaxation> relaxation;
    bool is_infeasible = false;  ///< a condition on parameters is unmet, and no variable affects it
    double fixed_residual = 0;   ///< norm of the residuals that no variable affects
    VectorX outer;
  };
  const GeometryRelaxation* relaxation_at(const BranchNode& branch);
  void find_outer(const BranchNode& root);

  const DesignProblem& problem_;
  std::vector<int> outer_;  ///< variables that must be fixed before there is a relaxation
  std::unique_ptr<const GeometryRelaxation> geometry_relaxation_;
  bool is_outer_known_ = false;
};

// Search over the nodes of a design problem with discrete values and choices.

/// A design in which all discrete decisions are made.
struct DiscreteCandidate {
  using Rank = DesignRating::Rank;
  Rank rank = Rank::conditions_violated;
  double value = 0;  ///< figure; violation of the limits; residual of the conditions, or the figure of such designs
  DesignOutcome outcome;
};

struct BranchAndBoundResult {
  std::optional<DiscreteCandidate> incumbent;
  bool is_exhausted = true;                                      ///< if no wanted design was found, none exists
  double lower_bound = std::numeric_limits<double>::infinity();  ///< of all wanted designs, found or not
};

/// Total effort of all searches for a design.
struct NodeCounts {
  int branches = 0, designs = 0;
};

class BranchAndBound {
 public:
  BranchAndBound(const DesignProblem& problem, SearchBudget& budget, NodeBounds& bounds, NodeCounts& node_counts)
      : problem_(problem), budget_(budget), bounds_(bounds), node_counts_(node_counts) {}

  BranchAndBoundResult run(const BranchingRule& branching, BranchObjective target);
  /// The best design of a leaf; std::nullopt if no design was found, or if its figure is proved to exceed max_figure.
  std::optional<DiscreteCandidate> solve_node(BranchNode leaf, double max_figure);
  /// A design of the first leaf that is allowed, for a search without time; std::nullopt if there is none.
  /// @param seconds CPU time that is granted
  std::optional<DiscreteCandidate> solve_first_leaf(const BranchingRule& branching, BranchObjective target,
                                                    double seconds);

 private:
  /// A leaf that may contain better designs than those found.
  struct UnprovedLeaf {
    BranchNode branch;  ///< with its lower bound
    bool has_relaxation = false;
    std::optional<DiscreteCandidate> candidate;
    VectorX relaxed_x;  ///< nearly attains the bound; may be empty
  };
  void process_node(const BranchingRule& branching, BranchNode branch);
  bool is_pruned(double lower_bound) const;
  bool solve_at_relaxed_solution(const BranchingRule& branching, const BranchNode& branch,
                                 const NodeBounds::Bound& bound);
  void solve_leaf(BranchNode branch, const NodeBounds::Bound& bound);
  void search_unproved_leaves();
  DesignProblem make_leaf_problem(const UnprovedLeaf& leaf) const;
  DesignProblem make_quick_leaf_problem(const UnprovedLeaf& leaf) const;
  std::optional<DiscreteCandidate> search_leaf(const DesignProblem& leaf_problem, UnprovedLeaf& leaf);
  void consider(const DiscreteCandidate& candidate);
  double leaf_bound(const BranchNode& branch, const std::optional<DiscreteCandidate>& candidate,
                    const DesignOutcome& outcome) const;
  static bool has_closed_gap(const DiscreteCandidate& candidate, double lower_bound);
  bool is_comparable(const std::optional<DiscreteCandidate>& candidate) const;
  std::optional<DiscreteCandidate> make_candidate(DesignOutcome outcome) const;
  bool is_done() const;

  const DesignProblem& problem_;
  SearchBudget& budget_;
  NodeBounds& bounds_;
  NodeCounts& node_counts_;
  BranchObjective target_ = BranchObjective::constrained_figure;
  std::vector<BranchNode> open_;  ///< the next one is last
  std::vector<UnprovedLeaf> unproved_leaves_;
  BranchAndBoundResult result_;
};

}  // namespace balance::design
