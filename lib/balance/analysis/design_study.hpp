#pragma once
/// A whole design: conditions, numbers that meet them, and every trajectory before and after.

#include "balance/analysis/load_case_report.hpp"
#include "balance/analysis/robust_figure.hpp"
#include "balance/design/solve.hpp"
#include "balance/result/result.hpp"
#include "balance/study/design_space.hpp"

#include <functional>
#include <string>
#include <vector>

namespace balance {

struct DesignStudyOptions {
  bool is_modular = false;              ///< the chains one by one (P0 section 2.2) instead of the complete conditions
  std::vector<Goal> goals;              ///< empty: the spec's; none there either: only `minimize`
  std::vector<std::string> excluded;    ///< what the goals leave out (ConditionOptions)
  std::vector<ObjectiveTerm> minimize;  ///< empty: the spec's
  SearchOptions search;
  std::function<bool(const SearchProgress&)> on_progress;  ///< as DesignProblem::watch
  bool compare_trajectories = true;                        ///< compare the spec's trajectories before and after
};

/// One trajectory before and after. Whichever could not be followed has an outcome that says so and no samples.
struct TrajectoryComparison {
  std::string trajectory;
  RunResult before, after;
};

struct DesignReport {
  DesignOutcome outcome;
  std::vector<FreeNumber> free_numbers;  ///< as in the study
  /// Values of the free numbers in the mechanism before: its start values, as every other command uses them.
  VectorX before;
  Study study_before, study_after;
  double mass_before = 0, mass_after = 0;  ///< of everything that moves [kg]
  /// Sum of the moments of inertia of everything that moves, about the carrying bodies' frame origins (space: half the
  /// trace) [kg m^2].
  double inertia_before = 0, inertia_after = 0;
  /// Of counterweights and discs in the designed mechanism, against none at all [kg], [kg m^2].
  double added_mass = 0, added_inertia = 0;
  std::vector<TrajectoryComparison> comparisons;
  std::vector<CardinalityConstraint> cardinality_constraints;  ///< of design.choose, as outcome.chosen
  std::vector<LoadCaseReport> load_cases;                      ///< of design.cases; empty: one load
  std::optional<AdaptiveReport> adaptive;                      ///< where numbers follow the load
  std::vector<RobustTerm> robust;  ///< what was minimized of means and deviations, designed; none with load cases
  std::vector<std::string> notes;
};

/// With load cases the outcome is that of all of them; its numbers, conditions and residuals are those at the spec's own load.
/// @throws std::invalid_argument if there are no free numbers, neither a goal nor something to minimize, or the objective's
///         trajectory does not exist; for a front (compute_pareto_front) unless the options say what to minimize; for load cases that change gravity, with the goals proportional and affine, and with modular
DesignReport run_design_study(const DesignSpace& space, const DesignStudyOptions& options);

}  // namespace balance
