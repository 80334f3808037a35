#pragma once
/// Sizes and elements to choose among, decided one after the other. Private to design.

#include "balance/design/problem.hpp"
#include "balance/design/relaxation.hpp"

namespace balance::designing {

/// Some of all designs.
struct Branch {
  enum class Fate { open, kept, left_out };
  VectorX lower, upper;     ///< of the numbers [SI]; of one with sizes: two of them, or one twice
  std::vector<Fate> fates;  ///< of the elements, choice by choice
  double least = -std::numeric_limits<double>::infinity();  ///< no wanted design in it is below
};

class Branching {
 public:
  /// @param least how many elements may be kept of all choices that ask for as few as will do
  Branching(const DesignProblem& problem, int least);

  Branch root() const;
  /// Carries on what follows from what is decided. @return false if nothing is left
  bool settle(Branch& branch) const;
  /// Whatever the other numbers are, sizes and counts are right.
  bool decided(const Branch& branch) const;
  /// Two or three parts that make up a branch that is not decided; the one to look at first stands last.
  /// @param x numbers that suit the branch if there were no sizes
  std::vector<Branch> split(const Branch& branch, const VectorX& x) const;
  /// The branch as bounds, with what counts of elements say of their numbers.
  Narrowed narrowed(const Branch& branch) const;
  /// Per choice and element: one of its numbers is not zero.
  std::vector<std::vector<bool>> kept(const VectorX& x) const;

  /// How many elements there are to choose among without a number, and in all.
  static int count_least(const DesignProblem& problem);

 private:
  struct Element {
    std::vector<int> numbers;
    std::size_t group;
  };
  bool settle_sizes(Branch& branch) const;
  bool settle_element(Branch& branch, std::size_t k) const;
  bool settle_counts(Branch& branch) const;
  int count(const Branch& branch, std::size_t group, Branch::Fate fate) const;
  /// How much of its range an element's numbers take up.
  double share(const Element& element, const VectorX& x) const;
  std::vector<Branch> split_element(const Branch& branch, std::size_t k) const;
  std::vector<Branch> split_number(const Branch& branch, int number, double at) const;

  const DesignProblem& problem_;
  std::vector<Element> elements_;
  std::vector<int> groups_;  ///< how many are kept at most
};

}  // namespace balance::designing
