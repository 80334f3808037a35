#pragma once
/// One design for one load, and one for several.

#include "balance/synthesis/design/case_objective.hpp"
#include "balance/synthesis/design/design_study.hpp"

#include <memory>

namespace balance {

// What a design comes to with one load.

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

/// What a spec asks a design for with its own load.
/// @param space must outlive the problem, and so must the terms of the options
/// @throws std::invalid_argument as run_design_study
DesignProblem make_design_problem(const DesignSpace& space, const DesignStudyOptions& options);

/// Studies, masses and inertias before and after, of the report's numbers.
void measure_design(const DesignSpace& space, DesignReport& report);

/// Runs every trajectory before and after.
void compare_trajectories(DesignReport& report);

/// One design for several loads: what is solved, and what is told of it.
class LoadCaseStudy {
 public:
  /// @param space must outlive the study @throws std::invalid_argument as run_design_study
  LoadCaseStudy(const DesignSpace& space, const DesignStudyOptions& options);
  ~LoadCaseStudy();

  /// Of the numbers of all cases.
  const DesignProblem& problem() const { return problem_; }
  const CaseSpace& cases() const;
  /// What the design does with one load after the other, by itself and where numbers follow the load.
  /// @param report with the outcome of problem(); its numbers, conditions and residuals become those at the spec's own load
  void describe(DesignReport& report) const;

 private:
  class CombinedCases;

  const DesignSpace& space_;
  DesignStudyOptions options_;
  std::shared_ptr<const CombinedCases> together_;
  DesignProblem conditions_problem_, problem_;
};

}  // namespace balance
