#pragma once
/// A whole design: conditions, numbers that meet them, and every trajectory before and after.

#include "balance/mechanics/results/result.hpp"
#include "balance/motion/study/design_space.hpp"
#include "balance/motion/study/study.hpp"
#include "balance/synthesis/conditions/unbalanceable_terms.hpp"
#include "balance/synthesis/design/adaptive_law.hpp"
#include "balance/synthesis/design/solve_design.hpp"
#include "balance/synthesis/tolerance/robust_figure.hpp"

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace balance {

// What a design for several loads comes to, load by load.

/// One trajectory with one load.
struct LoadCaseRun {
  std::string trajectory;
  MotionOutcome outcome;
  std::vector<Metric> metrics;  ///< of torques, shaking force and shaking moment
};

struct LoadCaseReport {
  VectorX loads;        ///< values of LoadCases::numbers
  VectorX x;            ///< of the spec's free numbers with this load
  double residual = 0;  ///< largest scaled residual of the goal's conditions; without a goal 0
  std::vector<PeakEffort>
      static_efforts;  ///< of every actuator over random poses; those that carry nothing are left out
  std::vector<LoadCaseRun> runs;
};

/// Adapted numbers at single loads, where there is no formula.
struct AdaptedTable {
  std::vector<VectorX> loads, values;
  std::vector<double> residuals;  ///< largest scaled residual at each load
  double midpoint_residual =
      0;  ///< the same halfway between two loads, by the spline through the values; one number of the load only
};

struct AdaptiveReport {
  std::vector<int> numbers;        ///< places of the adapted numbers among the spec's free numbers
  std::optional<AdaptiveLaw> law;  ///< else there is a table
  AdaptedTable table;
  VectorX min_values, max_values;  ///< of every adapted number over the range of the loads
  bool is_within_bounds = true;    ///< the law keeps the bounds of the free numbers
  std::optional<double>
      adjustment_work;  ///< against gravity and springs, from the least to the largest loads, at the start of the first
                        ///< trajectory [J]; nothing where masses change or there is no trajectory
  std::vector<LoadCaseReport> fixed_design_cases;  ///< the cases with the numbers that suit the spec's own load
};

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
///         trajectory does not exist; for a front (compute_pareto_front) unless the options say what to minimize; for load cases that
///         change gravity, with the goals proportional and affine, and with modular
DesignReport run_design_study(const DesignSpace& space, const DesignStudyOptions& options);

}  // namespace balance
