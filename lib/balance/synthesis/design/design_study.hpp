#pragma once
/// Complete design study: conditions, values that meet them, and all trajectories before and after.

#include "balance/mechanics/results/result.hpp"
#include "balance/motion/study/design_space.hpp"
#include "balance/motion/study/study.hpp"
#include "balance/synthesis/certificate/length_bound.hpp"
#include "balance/synthesis/conditions/unbalanceable_terms.hpp"
#include "balance/synthesis/design/adaptive_law.hpp"
#include "balance/synthesis/design/motion_cache.hpp"
#include "balance/synthesis/design/solve_design.hpp"
#include "balance/synthesis/tolerance/robust_figure.hpp"

#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace balance::design {

// Results of a design for several load cases.

/// One trajectory under one load.
struct LoadCaseRun {
  std::string trajectory;
  MotionOutcome outcome;
  std::vector<Metric> metrics;  ///< of torques, shaking force and shaking moment
};

struct LoadCaseReport {
  VectorX loads;        ///< values of LoadCases::numbers
  VectorX x;            ///< values of the spec's free numbers at this load
  double residual = 0;  ///< maximum scaled residual of the goal's conditions; 0 without a goal
  std::vector<conditions::PeakEffort>
      static_efforts;  ///< peak effort of each actuator over random poses; zero efforts are omitted
  std::vector<LoadCaseRun> runs;
};

/// Adapted numbers at individual loads, if there is no law.
struct AdaptedTable {
  std::vector<VectorX> loads, values;
  std::vector<double> residuals;  ///< maximum scaled residual at each load
  double midpoint_residual =
      0;  ///< the same halfway between two loads, with a spline through the values; only for a single load parameter
};

struct AdaptiveReport {
  std::vector<int> numbers;        ///< indices of the adapted numbers among the spec's free numbers
  std::optional<AdaptiveLaw> law;  ///< else there is a table
  AdaptedTable table;
  VectorX min_values, max_values;  ///< of each adapted number over the range of the loads
  bool is_within_bounds = true;    ///< whether the law satisfies the bounds of the free numbers
  std::optional<double>
      adjustment_work;  ///< against gravity and springs, from the minimum to the maximum loads, at the start of the
                        ///< first trajectory [J]; std::nullopt if masses change or there is no trajectory
  std::vector<LoadCaseReport> fixed_design_cases;  ///< the cases without adaptation, at the nominal numbers
};

struct DesignStudyOptions {
  bool is_modular = false;              ///< each chain separately (P0 section 2.2) instead of the complete conditions
  std::vector<Goal> goals;              ///< empty: the spec's; if the spec has none: only `minimize`
  std::vector<std::string> excluded;    ///< elements that the goals ignore (ConditionOptions)
  std::vector<ObjectiveTerm> minimize;  ///< empty: the spec's
  study::SearchOptions search;
  bool is_single_pass = false;                             ///< as in DesignProblem
  VectorX settled_values = {};                             ///< as in DesignProblem
  std::function<bool(const SearchProgress&)> on_progress;  ///< as DesignProblem::on_progress
  bool compare_trajectories = true;                        ///< run the spec's trajectories before and after
  bool keeps_certificates = false;                         ///< of the bound over all lengths
  std::shared_ptr<MotionCache> motions;                    ///< shared by several studies of one spec; null: none is
};

/// One trajectory before and after. A run that failed has no samples; its outcome says why.
struct TrajectoryComparison {
  std::string trajectory;
  RunResult before, after;
};

/// What was found out about the rows of catalogues.
struct CatalogueReport {
  std::vector<study::CatalogueChoice> choices;  ///< with the rows of the design
  bool is_searched = false;                     ///< some rows were free
  double combinations = 1;                      ///< of rows
  long solved = 0;                              ///< combinations for which a design was searched
  long branches = 0;                            ///< sets of rows and places that were bounded
  /// Of the objective, for all rows within the limits and all values of the free numbers; NaN: there is no bound.
  double lower_bound = std::numeric_limits<double>::quiet_NaN();
  bool is_proved = false;       ///< no other rows and places are better, but for the gap
  bool is_out_of_time = false;  ///< the search ended before all rows were decided
  std::string no_bound_reason;  ///< why rows could only be tried; empty: they were bounded
};

struct DesignReport {
  DesignOutcome outcome;
  std::vector<FreeNumber> free_numbers;  ///< as in the study
  /// Values of the free numbers in the original mechanism: the start values, as used by all other commands.
  VectorX before;
  Study study_before, study_after;
  double mass_before = 0, mass_after = 0;  ///< of all moving parts [kg]
  /// Sum of the moments of inertia of all moving parts about the frame origins of their bodies (spatial: half the
  /// trace) [kg m^2].
  double inertia_before = 0, inertia_after = 0;
  /// Total mass and inertia of counterweights and discs in the designed mechanism [kg], [kg m^2].
  double added_mass = 0, added_inertia = 0;
  std::vector<TrajectoryComparison> comparisons;
  std::vector<CardinalityConstraint> cardinality_constraints;  ///< of design.choose, in the order of outcome.selection
  std::vector<LoadCaseReport> load_cases;                      ///< of design.cases; empty: a single load
  std::optional<AdaptiveReport> adaptive;                      ///< if there are adapted numbers
  std::vector<tolerance::RobustTerm>
      robust;  ///< minimised terms with means and deviations, at the design; none with load cases
  std::optional<certificate::LengthBound> length_bound;  ///< over all lengths; none: it does not apply
  std::optional<CatalogueReport> catalogue;              ///< if elements are parts of catalogues
  std::vector<std::string> notes;
};

/// With load cases, the outcome is that of all cases together; its numbers, conditions and residuals are those at the
/// nominal load.
/// @throws std::invalid_argument if there are no free numbers; without a goal, objective and limits; if the trajectory
/// of the objective does not exist; for a front (compute_pareto_front) unless the options specify an objective; for
/// load cases that change gravity or are combined with the goals proportional and affine
DesignReport run_design_study(const DesignSpace& space, const DesignStudyOptions& options);

}  // namespace balance::design

namespace balance {

using design::DesignReport;
using design::DesignStudyOptions;
using design::run_design_study;

}  // namespace balance
