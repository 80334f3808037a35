#pragma once
/// Designs for a single load and for several load cases.

#include "balance/synthesis/design/case_objective.hpp"
#include "balance/synthesis/design/design_study.hpp"

#include <memory>

namespace balance::design {

// Evaluation of a design under one load.

/// Conditions of the goals as derived for a study, with moments about the reference point of its first trajectory.
class LoadCaseEvaluator {
 public:
  /// @param problem goals and options; must outlive this object
  LoadCaseEvaluator(const DesignProblem& problem, bool trajectories)
      : problem_(problem), simulates_trajectories_(trajectories) {}

  Conditions derive_conditions(const Study& loaded) const;
  Conditions derive_conditions(const Mechanism& assembled) const;
  /// Maximum scaled residual of the study's mechanism; NaN if the conditions cannot be derived, 0 without a goal.
  double max_residual(const Study& loaded) const;
  /// @param space at the load @param x values of its free numbers
  LoadCaseReport report(const DesignSpace& space, const VectorX& loads, const VectorX& x) const;

 private:
  const DesignProblem& problem_;
  bool simulates_trajectories_;
};

/// The design problem of a spec at its nominal load.
/// @param space must outlive the problem, and so must the terms of the options
/// @throws std::invalid_argument as run_design_study
DesignProblem make_design_problem(const DesignSpace& space, const DesignStudyOptions& options);

std::vector<DesignVariable> list_design_variables(const std::vector<FreeNumber>& numbers);

/// Sets the studies, masses and inertias before and after in the report.
void measure_design(const DesignSpace& space, DesignReport& report);

/// Runs all trajectories before and after.
void compare_trajectories(DesignReport& report);

/// A design for several load cases: its problem and the report on its solution.
class LoadCaseStudy {
 public:
  /// @param space must outlive the study @throws std::invalid_argument as run_design_study
  LoadCaseStudy(const DesignSpace& space, const DesignStudyOptions& options);
  ~LoadCaseStudy();

  /// In the numbers of all cases.
  const DesignProblem& problem() const { return problem_; }
  const CaseSpace& cases() const;
  /// Evaluates the design for each load, both with a fixed design and, if there are adapted numbers, with adaptation.
  /// @param report with the outcome of problem(); its numbers, conditions and residuals are converted to those at the
  /// nominal load
  void describe(DesignReport& report) const;

 private:
  class CaseDesignModel;
  DesignProblem make_problem() const;

  const DesignSpace& space_;
  DesignStudyOptions options_;
  std::shared_ptr<CaseDesignModel> case_model_;
  DesignProblem conditions_problem_, problem_;
};

}  // namespace balance::design
