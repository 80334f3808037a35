#pragma once
/// Finds numbers that balance a mechanism, or the best compromise and the reason why there is nothing better.

#include "balance/synthesis/conditions/infeasibility_certificate.hpp"
#include "balance/synthesis/design/design_problem.hpp"

namespace balance {

enum class DesignStatus {
  unsolved,    ///< nothing can be said: `reason` says why
  balanced,    ///< all conditions are met
  compromise,  ///< they are not, and whether they can be is not known
  infeasible,  ///< they cannot be: `reason` says why, `proved` whether that is shown; the numbers are the best compromise
  no_feasible_start,  ///< no numbers were found with which the mechanism can be assembled and make its motions; x is the start
  no_goal,            ///< there was no goal, only an objective
};

/// How good the design is in what it was to make small: the objective, or for a compromise without one what is left of the
/// conditions.
enum class Optimality {
  not_optimised,     ///< nothing was to be made small
  proved_global,     ///< `lower_bound` shows that nothing is better than by `gap`
  local_optimum,     ///< the best of what `tried` says; something better may exist
  budget_exhausted,  ///< the same, and the budget ended the search
};

/// What the solution rests on.
enum class DesignMethod {
  none,        ///< no condition depends on a free number
  affine,      ///< conditions affine in the numbers: linear algebra and bounds
  polynomial,  ///< Gauss–Newton on inertial numbers
  geometric,   ///< Gauss–Newton on lengths or ratios too
};

/// Ways to change a design without losing anything: to first order, within the bounds.
struct SolutionSet {
  int dimension = -1;               ///< of the designs that meet the conditions; −1: not counted
  int optimal_dimension = -1;       ///< of these, as good in the objective too; −1: not counted
  std::vector<int> free_variables;  ///< free numbers that may still change
};

/// What a search did, for those who judge whether it was enough.
struct SearchEffort {
  enum class Termination {
    not_searched,      ///< was searched
    goal_met,          ///< the goal, and nothing was to be made small
    starts_exhausted,  ///< all were used
    proved,            ///< that nothing is better
    time_limit,        ///< ran out
  };
  int starts = 0;  ///< from which conditions were solved
  int local_searches = 0;
  int repeated_optima = -1;  ///< of those over lengths: ended as well as the best one; −1: there were none
  int geometries = 0;        ///< sets of lengths at which masses were solved for
  int evaluations = 0;       ///< of the objective
  Termination termination = Termination::not_searched;
};

/// A limit and the design's figure.
struct LimitOutcome {
  double value = std::numeric_limits<double>::quiet_NaN();  ///< [SI]
  double violation = 0;    ///< how far beyond its bound, in parts of the bound; negative: what is left
  bool is_active = false;  ///< nothing is left, or less than nothing
};

/// Which elements were kept.
struct ElementSelection {
  std::vector<std::vector<bool>> kept;  ///< as the problem's choices and their elements
  int min_count = -1;  ///< so many at least are needed, of all that were to choose among; −1: not looked for
  bool is_min_count_proved = false;
};

struct DesignOutcome {
  DesignStatus status = DesignStatus::unsolved;
  DesignMethod method = DesignMethod::none;
  std::string reason;                                 ///< one or two sentences for the user
  VectorX x;                                          ///< the free numbers' values
  Conditions conditions;                              ///< at x's geometry
  VectorX residuals_before, residuals_after;          ///< scaled residuals at the start values and at x
  std::vector<std::vector<int>> condition_variables;  ///< per condition: free numbers that it depends on
  std::vector<int> unmet_fixed_conditions;            ///< conditions that no free number changes and that are not met
  std::vector<int> unmet_conditions;                  ///< conditions that x leaves open
  std::optional<InfeasibilityCertificate> certificate;
  double objective = std::numeric_limits<double>::quiet_NaN();        ///< at x
  double start_objective = std::numeric_limits<double>::quiet_NaN();  ///< at the start values
  /// What no exact design is below (without a goal, and for a compromise by the objective: no design at all), if proved.
  double lower_bound = std::numeric_limits<double>::quiet_NaN();
  Optimality optimality = Optimality::not_optimised;
  std::string search_summary;         ///< what was searched; empty if nothing was
  SearchEffort effort;                ///< the same in numbers
  bool is_proved_infeasible = false;  ///< impossible: it is shown, not only not found
  SolutionSet solution_set;           ///< of designs as good as this one
  std::vector<LimitOutcome> limits;   ///< as the problem's
  bool within_limits = true;
  std::optional<ElementSelection> selection;  ///< if there were choices
  /// Not within them: no design that was looked for is beyond the worst of them by less, if proved (as violation).
  double min_violation_bound = std::numeric_limits<double>::quiet_NaN();
  double gap() const { return objective - lower_bound; }
  std::vector<std::string> notes;
};

/// Scaled residual below which a condition counts as met.
inline constexpr double condition_tolerance = 1e-10;
/// Violation of a limit that counts as none.
inline constexpr double limit_tolerance = 1e-9;

/// In this order: conditions affine in the numbers, polynomial ones by Gauss–Newton with restarts, the best of the exact
/// solutions by the objective, a compromise by a global and a local search. Lengths and ratios are searched on a level above,
/// with the other numbers solved for at each of them. Bodies stay physical, mechanisms assembled throughout; numbers for which
/// an expression has no value, or the objective none, are no designs.
/// @throws std::invalid_argument for bounds that are not finite or do not hold the start value, for search options out of
///         range, and if there is neither a goal nor an objective
DesignOutcome solve_design(const DesignProblem& problem);

/// Springs of zero free length whose ends are free numbers: with their products as parameters (problem.options.loose_springs)
/// the conditions do not depend on the free numbers. solve() adds them by itself; objectives of parameters see the
/// parameters as listed with problem.options, so ask here before building them from forces.
FreeSprings find_loose_springs(const DesignProblem& problem);

}  // namespace balance
