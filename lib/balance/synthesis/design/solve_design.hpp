#pragma once
/// Finds values of the free numbers that balance a mechanism, or the best compromise and the reason why it cannot be
/// improved.

#include "balance/synthesis/conditions/infeasibility_certificate.hpp"
#include "balance/synthesis/design/design_problem.hpp"
#include "balance/synthesis/design/start_agreement.hpp"

namespace balance::design {

enum class DesignStatus {
  unsolved,    ///< no result; see `reason`
  balanced,    ///< all conditions are met
  compromise,  ///< not all conditions are met, and whether they can be is unknown
  infeasible,  ///< the conditions cannot be met: see `reason` and `is_proved_infeasible`; x is the best compromise
  no_feasible_start,  ///< no start was found where the mechanism can be assembled and move; x is the start
  no_goal,            ///< there was no goal, only an objective
};

/// Optimality with respect to the objective or, for a compromise without one, the residual of the conditions.
enum class Optimality {
  not_optimised,     ///< nothing was minimised
  proved_global,     ///< `lower_bound` proves that no design is better by more than `gap`
  local_optimum,     ///< the best result of the search in `search_summary`; better ones may exist
  budget_exhausted,  ///< the same, but the search ended for lack of time
};

/// The method that found the solution.
enum class DesignMethod {
  none,        ///< no condition depends on a free number
  affine,      ///< conditions affine in the free numbers: linear algebra and bounds
  polynomial,  ///< Gauss–Newton on inertial variables
  geometric,   ///< Gauss–Newton on lengths or ratios, too
};

/// Dimension of the set of equivalent designs: to first order, within the bounds.
struct SolutionSet {
  int dimension = -1;               ///< of the designs that meet the conditions; −1: not computed
  int optimal_dimension = -1;       ///< of those with the same objective; −1: not computed
  std::vector<int> free_variables;  ///< indices of the free numbers that may still vary
};

/// Effort of a search, to judge whether it was sufficient.
struct SearchEffort {
  enum class Termination {
    not_searched,      ///< no search was necessary
    goal_met,          ///< the goal is met, and there was no objective
    starts_exhausted,  ///< all starts were used
    proved,            ///< optimality was proved
    time_limit,        ///< the time limit was reached
    starts_agree,      ///< enough independent starts ended at the best value
  };
  int starts = 0;  ///< number of starts for solving the conditions
  int local_searches = 0;
  int geometries = 0;        ///< number of sets of lengths at which the masses were solved for
  int evaluations = 0;       ///< of the objective
  std::vector<double> ends;  ///< values of the objective at the ends of independent starts; NaN: without a design
  Termination termination = Termination::not_searched;
  long combinations = 0;                ///< of sizes that were tried, if all variables have sizes
  bool tried_all_combinations = false;  ///< whether there are no others
};

/// A limit and the value of its figure.
struct LimitOutcome {
  double value = std::numeric_limits<double>::quiet_NaN();  ///< [SI]
  double violation = 0;                                     ///< relative to the bound; negative: margin
  bool is_active = false;                                   ///< no margin, or violated
};

/// A length or ratio that cannot change further although its bounds would permit it: the mechanism cannot be assembled
/// there, leaves its assembly mode or cannot complete its motion.
struct FeasibilityEdge {
  int variable = 0;
  bool is_upper = false;  ///< whether larger values are infeasible; else smaller ones
  std::string reason;
};

/// The elements that were kept.
struct ElementSelection {
  std::vector<std::vector<bool>> kept;  ///< for each of the problem's choices and its elements
  int min_count = -1;                   ///< minimum number of elements needed among all choices; −1: not determined
  bool is_min_count_proved = false;
};

struct DesignOutcome {
  DesignStatus status = DesignStatus::unsolved;
  DesignMethod method = DesignMethod::none;
  std::string reason;                                 ///< one or two sentences for the user
  VectorX x;                                          ///< values of the free numbers
  Conditions conditions;                              ///< at the geometry of x
  VectorX residuals_before, residuals_after;          ///< scaled residuals at the start values and at x
  std::vector<std::vector<int>> condition_variables;  ///< per condition: the free numbers that it depends on
  std::vector<int> unmet_fixed_conditions;            ///< unmet conditions that no free number changes
  std::vector<int> unmet_conditions;                  ///< conditions that x does not meet
  std::optional<conditions::InfeasibilityCertificate> certificate;
  double objective = std::numeric_limits<double>::quiet_NaN();        ///< at x
  double start_objective = std::numeric_limits<double>::quiet_NaN();  ///< at the start values
  /// Proved lower bound of the objective for all exact designs (without a goal, and for a compromise by the objective:
  /// for all designs).
  double lower_bound = std::numeric_limits<double>::quiet_NaN();
  Optimality optimality = Optimality::not_optimised;
  std::string search_summary;         ///< description of the search; empty if there was none
  SearchEffort effort;                ///< the same in numbers
  bool is_proved_infeasible = false;  ///< whether infeasibility is proved rather than concluded from a failed search
  SolutionSet solution_set;           ///< of equivalent designs
  std::vector<LimitOutcome> limits;   ///< in the order of the problem
  bool within_limits = true;
  std::vector<FeasibilityEdge> edges;         ///< at which the design lies
  std::optional<ElementSelection> selection;  ///< if there were choices
  /// If the limits are violated: proved lower bound of the violation of the worst limit.
  double min_violation_bound = std::numeric_limits<double>::quiet_NaN();
  /// 0 if it is proved that there is none: the rest is the tolerance of the proof.
  double gap() const { return optimality == Optimality::proved_global ? 0 : objective - lower_bound; }
  std::vector<std::string> notes;
};

/// Whether the conditions are met, if there are any.
inline bool is_success(const DesignOutcome& outcome) {
  return outcome.status == DesignStatus::balanced || outcome.status == DesignStatus::no_goal;
}

/// The same within all limits.
inline bool is_design(const DesignOutcome& outcome) { return is_success(outcome) && outcome.within_limits; }

/// Scaled residual below which a condition counts as met.
inline constexpr double condition_tolerance = 1e-10;
/// Violation up to which a limit counts as satisfied.
inline constexpr double limit_tolerance = 1e-9;

/// Solves a design problem. Conditions affine in the free numbers are solved by linear algebra, polynomial ones by
/// Gauss–Newton with restarts. The objective is then minimised among the exact solutions. Without exact solutions, a
/// global and a local search find a compromise. An upper level searches lengths and ratios, solving for the other
/// numbers at each of them. Bodies stay physical and mechanisms assembled throughout; points without a value of an
/// expression or of the objective are rejected.
/// @throws std::invalid_argument if bounds are not finite or do not contain the start value, if search options are out
/// of range, or if there is neither a goal nor an objective nor a limit
DesignOutcome solve_design(const DesignProblem& problem);

/// Does for a subproblem's design what solve_design() does last: chooses among equal designs, finds what may still
/// change, and at what lengths it ends.
/// @param seconds left for the search
void complete_design(const DesignProblem& problem, double seconds, DesignOutcome& outcome);

/// Springs of zero free length whose end points are free numbers. If their products are parameters
/// (problem.options.loose_springs), the conditions do not depend on the free numbers. solve_design() adds them
/// automatically. Objectives of parameters use the parameters as listed with problem.options, so call this function
/// before building them from forces.
dynamics::FreeSprings find_loose_springs(const DesignProblem& problem);

}  // namespace balance::design

namespace balance {

using design::DesignStatus;

}  // namespace balance
