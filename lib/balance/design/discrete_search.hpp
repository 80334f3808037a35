#pragma once
/// One walk through the branches of a design problem with sizes and choices. Private to design.

#include "balance/design/discrete_bounds.hpp"
#include "balance/design/solve.hpp"

namespace balance::designing {

/// A figure may be above its bound by this part, which is round-off of the convex problem.
inline constexpr double bound_falls_short = 1e-6;

/// A design with all sizes decided.
struct SizedDesign {
  enum class Rank { exact, beyond_limits, unmet };
  Rank rank = Rank::unmet;
  double value =
      0;  ///< the figure; by how much limits are missed; what is left of the conditions, or the figure of those
  DesignOutcome outcome;
};

struct Walk {
  std::optional<SizedDesign> best;
  bool closed = true;                                      ///< if none was found that was wanted, there is none
  double bound = std::numeric_limits<double>::infinity();  ///< no design that was wanted is below it, found or not
};

/// What all walks of a design have spent.
struct Steps {
  int branches = 0, designs = 0;
};

class DiscreteSearch {
 public:
  DiscreteSearch(const DesignProblem& problem, Budget& budget, DiscreteBounds& bounds, Steps& steps)
      : problem_(problem), budget_(budget), bounds_(bounds), steps_(steps) {}

  Walk run(const Branching& branching, Wanted wanted);

 private:
  void look_at(const Branching& branching, Branch branch);
  void try_design(const Branch& branch, double least, bool bounded);
  double bound_of(const Branch& branch, double least, const std::optional<SizedDesign>& design,
                  const DesignOutcome& outcome) const;
  std::optional<SizedDesign> rated(DesignOutcome outcome) const;
  bool done() const;

  const DesignProblem& problem_;
  Budget& budget_;
  DiscreteBounds& bounds_;
  Steps& steps_;
  Wanted wanted_ = Wanted::exact;
  std::vector<Branch> open_;  ///< the next one last
  Walk walk_;
};

}  // namespace balance::designing
