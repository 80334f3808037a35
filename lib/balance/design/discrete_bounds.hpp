#pragma once
/// What parts of a design problem with sizes and choices cannot be better than. Private to design.

#include "balance/design/branching.hpp"
#include "balance/design/equations.hpp"

#include <memory>

namespace balance::designing {

/// What a search among sizes looks for.
enum class Wanted {
  exact,     ///< designs that meet the conditions, of them the least figure
  figure,    ///< the least figure, whatever the conditions
  residual,  ///< the least that is left of the conditions
};

/// The problem within a branch, without sizes and choices.
/// @param seconds that its search may take
DesignProblem within(const DesignProblem& problem, const Branch& branch, double seconds);

class DiscreteBounds {
 public:
  explicit DiscreteBounds(const DesignProblem& problem) : problem_(problem) {}

  struct Answer {
    bool known = false;                                       ///< there is a convex problem that says so
    bool possible = true;                                     ///< false: the branch holds no such design
    double least = -std::numeric_limits<double>::infinity();  ///< no such design has a figure (what is left) below it
    VectorX x;  ///< numbers between the sizes that come near it; may be empty
  };
  /// Conditions of all designs, in one scale; null where they are not the same for all.
  const Conditions* shared_conditions(const Branch& root);
  Answer operator()(const Branch& branch, const Narrowed& part, Wanted wanted);

 private:
  /// One geometry, and all that can be decided at it.
  struct Place {
    Place(const DesignProblem& whole, const Branch& branch);
    DesignProblem problem;
    Budget budget;
    Context context;
    Conditions conditions;
    std::optional<Relaxation> relaxation;
    bool impossible = false;  ///< a condition on parameters is not met, and no number changes it
    double fixed_left = 0;    ///< what is left of conditions that no number changes
    VectorX outer;
  };
  const Place* place(const Branch& branch);
  void find_outer(const Branch& root);

  const DesignProblem& problem_;
  std::vector<int> outer_;  ///< numbers whose values must be decided first
  std::unique_ptr<const Place> place_;
  bool tried_ = false;
};

}  // namespace balance::designing
