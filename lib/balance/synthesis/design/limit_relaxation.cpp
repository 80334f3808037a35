#include "balance/synthesis/design/limit_relaxation.hpp"

#include "balance/foundation/base/cpu_time.hpp"
#include "balance/synthesis/design/derived_problems.hpp"
#include "balance/synthesis/design/problem_functions.hpp"
#include "balance/synthesis/design/solution_analysis.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace balance::design {

namespace {

/// Fraction of the time that the problem without its limits may take.
constexpr double relaxed_time_fraction = 0.3;

bool is_convex(const DesignLimit& limit) {
  return limit.figure.is_constant || (limit.is_lower ? limit.figure.is_concave : limit.figure.is_convex);
}

/// The problem without the limits that are not convex; std::nullopt if there are none, or if no proof is to be expected.
std::optional<DesignProblem> without_nonconvex_limits(const DesignProblem& problem) {
  const bool is_provable =
      problem.objective && (problem.objective->is_convex || problem.model->capabilities().has_convex_terms);
  if (problem.is_subproblem || !is_provable || std::all_of(problem.limits.begin(), problem.limits.end(), is_convex))
    return std::nullopt;
  SearchBudget budget(problem.search.max_time);
  if (SolverContext(problem, budget).classification.has_geometric()) return std::nullopt;
  DesignProblem relaxed = problem;
  std::erase_if(relaxed.limits, [](const DesignLimit& limit) { return !is_convex(limit); });
  relaxed.search.max_time *= relaxed_time_fraction;
  return relaxed;
}

/// Limits with a violation above minus this are active.
constexpr double active_limit_tolerance = 1e-5;

/// The start values as the only design.
DesignProblem fix_at_start(const DesignProblem& problem) {
  DesignProblem fixed = problem;
  for (DesignVariable& variable : fixed.variables) variable.lower = variable.upper = variable.start;
  fixed.is_subproblem = true;
  return fixed;
}

}  // namespace

void evaluate_limits(const DesignProblem& problem, DesignOutcome& outcome) {
  outcome.limits.clear();
  double worst = -std::numeric_limits<double>::infinity();
  for (const DesignLimit& limit : problem.limits) {
    LimitOutcome limit_outcome;
    limit_outcome.value = evaluate_figure(problem, limit.figure, outcome.x);
    limit_outcome.violation = relative_violation(limit, limit_outcome.value);
    // a violation of a bound of zero is absolute
    if (limit.bound == 0 && std::abs(limit_outcome.value) <= limit_tolerance) limit_outcome.value = 0;
    limit_outcome.is_active = !(limit_outcome.violation < -active_limit_tolerance);
    outcome.limits.push_back(limit_outcome);
    if (!(limit_outcome.violation <= worst)) worst = limit_outcome.violation;
  }
  outcome.within_limits = worst <= limit_tolerance;
}

double max_limit_violation(const DesignOutcome& outcome) {
  double largest = 0;
  for (const LimitOutcome& limit : outcome.limits) largest = std::max(largest, limit.violation);
  return largest;
}

DesignOutcome solve_with_limits(const DesignProblem& problem,
                                const std::function<DesignOutcome(const DesignProblem&)>& search) {
  const double start_time = thread_cpu_time();
  double lower_bound = std::numeric_limits<double>::quiet_NaN();
  DesignProblem remaining = problem;
  if (const std::optional<DesignProblem> relaxed = without_nonconvex_limits(problem)) {
    DesignOutcome optimum = search(*relaxed);
    const bool is_proved = is_design(optimum) && optimum.optimality == Optimality::proved_global;
    if (is_design(optimum)) lower_bound = optimum.lower_bound;
    if (is_proved) {
      evaluate_limits(problem, optimum);
      if (optimum.within_limits) return optimum;
    }
    remaining.search.max_time = std::max(1e-3, problem.search.max_time - (thread_cpu_time() - start_time));
  }
  DesignOutcome outcome = search(remaining);
  if (!outcome.within_limits && !problem.is_subproblem && outcome.x.size() > 0) {
    DesignOutcome start = search(fix_at_start(problem));
    if (is_design(start)) {
      start.optimality = problem.objective ? Optimality::local_optimum : Optimality::not_optimised;
      start.effort = outcome.effort;
      outcome = std::move(start);
    }
  }
  if (is_design(outcome) && outcome.optimality != Optimality::proved_global && std::isfinite(lower_bound))
    raise_lower_bound(outcome, lower_bound);
  return outcome;
}

}  // namespace balance::design
