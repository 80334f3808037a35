#pragma once
/// Sizes and elements to choose among, decided one after the other. Private to design.

#include "balance/design/problem.hpp"
#include "balance/design/relaxation.hpp"

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

}  // namespace balance::design
