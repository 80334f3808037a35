#include "balance/synthesis/design/solve_design.hpp"

#include "balance/foundation/base/cpu_time.hpp"
#include "balance/foundation/base/error.hpp"
#include "balance/synthesis/design/branch_and_bound.hpp"
#include "balance/synthesis/design/derived_problems.hpp"
#include "balance/synthesis/design/discrete_design.hpp"
#include "balance/synthesis/design/problem_functions.hpp"
#include "balance/synthesis/design/solve_once.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace balance::design {

// Proofs for designs whose conditions are products of masses and places.

/// Where masses and first moments make a convex problem of the numbers: its least figure is a bound of every design's, and what it leaves
/// of the conditions, if anything, is left by every choice of the numbers.
/// @param again the search from other start values
void bound_by_relaxation(const DesignProblem& problem, DesignOutcome& outcome,
                         const std::function<DesignOutcome(const DesignProblem&)>& again);

namespace {

bool is_bound_useful(const DesignProblem& problem, const DesignOutcome& outcome) {
  if (problem.is_subproblem || problem.is_modular || !outcome.within_limits) return false;
  const bool without_goal = outcome.status == DesignStatus::no_goal;
  if (outcome.method != DesignMethod::polynomial && !without_goal) return false;
  if (outcome.status == DesignStatus::compromise) return true;
  return problem.objective && problem.all_convex_terms_at && outcome.optimality == Optimality::local_optimum &&
         (without_goal || outcome.status == DesignStatus::balanced);
}

void restart_from(const DesignProblem& problem, const VectorX& from, DesignOutcome& outcome,
                  const std::function<DesignOutcome(const DesignProblem&)>& again) {
  DesignProblem other = problem;
  for (std::size_t i = 0; i < other.variables.size(); ++i)
    other.variables[i].start =
        std::clamp(from[static_cast<Eigen::Index>(i)], other.variables[i].lower, other.variables[i].upper);
  DesignOutcome found = again(other);
  if (found.status != outcome.status || !(found.objective < outcome.objective)) return;
  found.residuals_before = outcome.residuals_before;
  found.start_objective = outcome.start_objective;
  outcome = std::move(found);
}

}  // namespace

void bound_by_relaxation(const DesignProblem& problem, DesignOutcome& outcome,
                         const std::function<DesignOutcome(const DesignProblem&)>& again) {
  if (!is_bound_useful(problem, outcome)) return;
  const BranchingRule all(problem, 0);
  const BranchNode root = all.root();
  NodeBounds bounds(problem);
  const NodeBounds::Bound bound = bounds(root, all.node_domain(root), BranchObjective::constrained_figure);
  if (!bound.has_relaxation) return;
  if (outcome.status == DesignStatus::compromise) {
    if (bound.is_feasible || !outcome.unmet_fixed_conditions.empty()) return;
    outcome.status = DesignStatus::infeasible;
    outcome.is_proved_infeasible = true;
    outcome.reason = "no masses and first moments within the bounds of the free numbers meet the conditions";
    return;
  }
  if (!std::isfinite(bound.lower_bound)) return;
  const auto close = [&] {
    return outcome.objective - bound.lower_bound <= relative_gap_tolerance * std::abs(outcome.objective);
  };
  if (!close() && bound.x.size() > 0) restart_from(problem, bound.x, outcome, again);
  outcome.lower_bound = std::min(bound.lower_bound, outcome.objective);
  if (!close()) return;
  outcome.optimality = Optimality::proved_global;
  outcome.effort.termination = SearchEffort::Termination::proved;
}

}  // namespace balance::design

namespace balance {

namespace {

using namespace design;

/// Limits that are missed or kept by less are active.
constexpr double active_limit_tolerance = 1e-5;

bool is_success(const DesignOutcome& outcome) {
  return outcome.status == DesignStatus::balanced || outcome.status == DesignStatus::no_goal;
}

/// A design within limits: first as if it lay at hand; where that fails, or ends without the proof that could be had, from the
/// design that is least beyond the limits, or farthest within them.
class LimitedDesignSolver {
 public:
  explicit LimitedDesignSolver(const DesignProblem& problem) : problem_(problem), begin_(thread_cpu_time()) {}

  DesignOutcome run() {
    if (problem_.goals.empty() && !problem_.objective) return solve_limits_only();
    SingleSolve first = solve_once(problem_);
    evaluate_limits(first.outcome);
    const DesignStatus status = first.outcome.status;
    const bool at_hand = is_success(first.outcome) && first.outcome.within_limits;
    const bool proved = first.outcome.optimality == Optimality::proved_global || !first.is_convex;
    if ((at_hand && proved) || status == DesignStatus::unsolved || status == DesignStatus::no_feasible_start ||
        is_budget_exhausted(first))
      return first.outcome;
    DesignOutcome least = solve_once(make_phase_one_problem(remaining(problem_))).outcome;
    evaluate_limits(least);
    if (is_success(least) && least.within_limits)
      return choose_better(std::move(first.outcome), solve_from(std::move(least)));
    if (at_hand || (!is_success(least) && first.outcome.within_limits)) return first.outcome;
    return make_violating_outcome(std::move(least), first.outcome);
  }

 private:
  /// Neither a goal nor an objective.
  DesignOutcome solve_limits_only() const {
    DesignOutcome outcome = solve_once(make_phase_one_problem(problem_)).outcome;
    evaluate_limits(outcome);
    if (outcome.status == DesignStatus::unsolved) return outcome;
    if (!outcome.within_limits) return make_violating_outcome(outcome, outcome);
    reset_objective(outcome);
    outcome.optimality = Optimality::not_optimised;
    return outcome;
  }

  /// Nothing is left to search with.
  bool is_budget_exhausted(const SingleSolve& pass) const {
    return pass.outcome.within_limits && pass.outcome.optimality == Optimality::budget_exhausted;
  }

  DesignProblem remaining(DesignProblem problem) const {
    problem.search.max_time = std::max(1e-3, problem.search.max_time - (thread_cpu_time() - begin_));
    return problem;
  }

  void evaluate_limits(DesignOutcome& outcome) const {
    outcome.limits.clear();
    double worst = -std::numeric_limits<double>::infinity();
    for (const DesignLimit& limit : problem_.limits) {
      LimitOutcome one;
      one.value = evaluate_figure(problem_, limit.figure, outcome.x);
      one.violation = relative_violation(limit, one.value);
      one.is_active = !(one.violation < -active_limit_tolerance);
      outcome.limits.push_back(one);
      if (!(one.violation <= worst)) worst = one.violation;
    }
    outcome.within_limits = worst <= limit_tolerance;
  }

  /// The search once more, from a design within the limits; or that design.
  DesignOutcome solve_from(DesignOutcome within) const {
    DesignProblem problem = remaining(problem_);
    for (std::size_t i = 0; i < problem.variables.size(); ++i)
      problem.variables[i].start = within.x[static_cast<Eigen::Index>(i)];
    DesignOutcome again = solve_once(problem).outcome;
    evaluate_limits(again);
    if (is_success(again) && again.within_limits) return again;
    reset_objective(within);
    within.optimality = !problem_.objective                                ? Optimality::not_optimised
                        : again.optimality == Optimality::budget_exhausted ? Optimality::budget_exhausted
                                                                           : Optimality::local_optimum;
    return within;
  }

  /// What the least violation's outcome says of itself, said of the objective.
  void reset_objective(DesignOutcome& outcome) const {
    outcome.lower_bound = outcome.objective = outcome.start_objective = std::numeric_limits<double>::quiet_NaN();
    outcome.solution_set = {};
    outcome.notes.clear();
    if (!problem_.objective) return;
    outcome.objective = evaluate_figure(problem_, *problem_.objective, outcome.x);
    VectorX start(static_cast<Eigen::Index>(problem_.variables.size()));
    for (Eigen::Index i = 0; i < start.size(); ++i) start[i] = problem_.variables[static_cast<std::size_t>(i)].start;
    outcome.start_objective = evaluate_figure(problem_, *problem_.objective, start);
  }

  /// @param first may be none within the limits
  static DesignOutcome choose_better(DesignOutcome first, DesignOutcome second) {
    second.start_objective = first.start_objective;
    second.residuals_before =
        first.residuals_before.size() == second.residuals_after.size() ? first.residuals_before : VectorX();
    const bool usable = is_success(first) && first.within_limits;
    if (!usable || second.optimality == Optimality::proved_global || second.objective < first.objective) return second;
    return first;
  }

  /// No design keeps the limits: the one that is least beyond the worst of them.
  DesignOutcome make_violating_outcome(DesignOutcome least, const DesignOutcome& first) const {
    const bool otherwise_done = is_success(least);
    const double bound = least.lower_bound;
    const bool proved = otherwise_done && bound > limit_tolerance;
    const bool best = least.optimality == Optimality::proved_global;
    const std::string reason = least.reason;
    reset_objective(least);
    least.start_objective = first.start_objective;
    if (otherwise_done) {
      least.status = proved ? DesignStatus::infeasible : DesignStatus::compromise;
      least.is_proved_infeasible = proved;
    }
    if (proved) least.min_violation_bound = bound;
    least.reason = (otherwise_done || reason.empty() ? "" : reason + "; ") + describe_violation(least, proved, best);
    return least;
  }

  std::string describe_violation(const DesignOutcome& outcome, bool proved, bool best) const {
    std::size_t worst = 0;
    for (std::size_t k = 1; k < outcome.limits.size(); ++k)
      if (!(outcome.limits[k].violation <= outcome.limits[worst].violation)) worst = k;
    const double beyond = outcome.limits[worst].violation;
    const DesignLimit& limit = problem_.limits[worst];
    const std::string where = limit.bound != 0
                                  ? fmt::format("{} is missed by {:.3g} % of its bound", limit.text, 100 * beyond)
                                  : fmt::format("{} is missed by {:.3g}", limit.text, beyond);
    const char* others = problem_.goals.empty() ? "" : " and meets the conditions";
    if (!std::isfinite(beyond)) return fmt::format("{} cannot be computed", limit.text);
    if (proved)
      return fmt::format("no choice of the free numbers keeps all limits{}: {}{}", others, where,
                         best ? ", and with no other choice is the worst of them missed by less" : "");
    return fmt::format("no choice of the free numbers was found that keeps all limits{}: {}", others, where);
  }

  const DesignProblem& problem_;
  double begin_;
};

}  // namespace

DesignOutcome solve_design(const DesignProblem& problem) {
  problem.search.validate();
  if (problem.goals.empty() && !problem.objective && problem.limits.empty())
    throw std::invalid_argument("a design needs a goal, something to minimize or limits");
  if (is_discrete(problem)) return solve_discrete(problem);
  const auto search = [](const DesignProblem& one) {
    return one.limits.empty() ? solve_once(one).outcome : LimitedDesignSolver(one).run();
  };
  DesignOutcome outcome = search(problem);
  bound_by_relaxation(problem, outcome, search);
  return outcome;
}

}  // namespace balance
