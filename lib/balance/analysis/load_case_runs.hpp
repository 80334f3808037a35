#pragma once
/// What a design comes to with one load. Private to analysis.

#include "balance/analysis/design_study.hpp"

namespace balance {

/// Conditions of the goals as derived for a study, about its first trajectory's point.
class LoadCaseEvaluator {
 public:
  /// @param problem goals and options; must outlive the judge
  LoadCaseEvaluator(const DesignProblem& problem, bool trajectories) : problem_(problem), trajectories_(trajectories) {}

  Conditions derive_conditions(const Study& loaded) const;
  Conditions derive_conditions(const Mechanism& assembled) const;
  /// Largest scaled residual of a study's mechanism; NaN where there are no conditions, 0 without a goal.
  double max_residual(const Study& loaded) const;
  /// @param space at the load @param x values of its free numbers
  LoadCaseReport report(const DesignSpace& space, const VectorX& loads, const VectorX& x) const;

 private:
  const DesignProblem& problem_;
  bool trajectories_;
};

}  // namespace balance
