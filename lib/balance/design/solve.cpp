#include "balance/design/solve.hpp"

#include "balance/base/computing_time.hpp"
#include "balance/base/error.hpp"
#include "balance/design/discrete.hpp"
#include "balance/design/least_violation.hpp"
#include "balance/design/limits.hpp"
#include "balance/design/one_pass.hpp"
#include "balance/design/relaxed_bound.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace balance {

namespace {

using namespace designing;

/// Limits that are missed or kept by less are active.
constexpr double nearly_active = 1e-5;

bool is_done(const DesignOutcome& outcome) {
  return outcome.status == DesignStatus::balanced || outcome.status == DesignStatus::not_asked;
}

/// A design within limits: first as if it lay at hand; where that fails, or ends without the proof that could be had, from the
/// design that is least beyond the limits, or farthest within them.
class LimitedDesign {
 public:
  explicit LimitedDesign(const DesignProblem& problem) : problem_(problem), begin_(computing_time()) {}

  DesignOutcome run() {
    if (problem_.goals.empty() && !problem_.objective) return limits_alone();
    Pass first = pass_once(problem_);
    measure(first.outcome);
    const DesignStatus status = first.outcome.status;
    const bool at_hand = is_done(first.outcome) && first.outcome.within_limits;
    const bool proved = first.outcome.optimality == Optimality::proved_best || !first.convex;
    if ((at_hand && proved) || status == DesignStatus::unsolved || status == DesignStatus::not_found || over(first))
      return first.outcome;
    DesignOutcome least = pass_once(least_violation(remaining(problem_))).outcome;
    measure(least);
    if (is_done(least) && least.within_limits) return best(std::move(first.outcome), from(std::move(least)));
    if (at_hand || (!is_done(least) && first.outcome.within_limits)) return first.outcome;
    return beyond(std::move(least), first.outcome);
  }

 private:
  /// Neither a goal nor an objective.
  DesignOutcome limits_alone() const {
    DesignOutcome outcome = pass_once(least_violation(problem_)).outcome;
    measure(outcome);
    if (outcome.status == DesignStatus::unsolved) return outcome;
    if (!outcome.within_limits) return beyond(outcome, outcome);
    restate(outcome);
    outcome.optimality = Optimality::not_asked;
    return outcome;
  }

  /// Nothing is left to search with.
  bool over(const Pass& pass) const {
    return pass.outcome.within_limits && pass.outcome.optimality == Optimality::stopped;
  }

  DesignProblem remaining(DesignProblem problem) const {
    problem.search.seconds = std::max(1e-3, problem.search.seconds - (computing_time() - begin_));
    return problem;
  }

  void measure(DesignOutcome& outcome) const {
    outcome.limits.clear();
    double worst = -std::numeric_limits<double>::infinity();
    for (const DesignLimit& limit : problem_.limits) {
      LimitOutcome one;
      one.value = value_of(problem_, limit.figure, outcome.x);
      one.violation = violation(limit, one.value);
      one.active = !(one.violation < -nearly_active);
      outcome.limits.push_back(one);
      if (!(one.violation <= worst)) worst = one.violation;
    }
    outcome.within_limits = worst <= kept;
  }

  /// The search once more, from a design within the limits; or that design.
  DesignOutcome from(DesignOutcome within) const {
    DesignProblem problem = remaining(problem_);
    for (std::size_t i = 0; i < problem.variables.size(); ++i)
      problem.variables[i].start = within.x[static_cast<Eigen::Index>(i)];
    DesignOutcome again = pass_once(problem).outcome;
    measure(again);
    if (is_done(again) && again.within_limits) return again;
    restate(within);
    within.optimality = !problem_.objective                       ? Optimality::not_asked
                        : again.optimality == Optimality::stopped ? Optimality::stopped
                                                                  : Optimality::local_best;
    return within;
  }

  /// What the least violation's outcome says of itself, said of the objective.
  void restate(DesignOutcome& outcome) const {
    outcome.lower_bound = outcome.objective = outcome.objective_start = std::numeric_limits<double>::quiet_NaN();
    outcome.freedom = {};
    outcome.notes.clear();
    if (!problem_.objective) return;
    outcome.objective = value_of(problem_, *problem_.objective, outcome.x);
    VectorX start(static_cast<Eigen::Index>(problem_.variables.size()));
    for (Eigen::Index i = 0; i < start.size(); ++i) start[i] = problem_.variables[static_cast<std::size_t>(i)].start;
    outcome.objective_start = value_of(problem_, *problem_.objective, start);
  }

  /// @param first may be none within the limits
  static DesignOutcome best(DesignOutcome first, DesignOutcome second) {
    second.objective_start = first.objective_start;
    second.before = first.before.size() == second.after.size() ? first.before : VectorX();
    const bool usable = is_done(first) && first.within_limits;
    if (!usable || second.optimality == Optimality::proved_best || second.objective < first.objective) return second;
    return first;
  }

  /// No design keeps the limits: the one that is least beyond the worst of them.
  DesignOutcome beyond(DesignOutcome least, const DesignOutcome& first) const {
    const bool otherwise_done = is_done(least);
    const double bound = least.lower_bound;
    const bool proved = otherwise_done && bound > kept;
    const bool best = least.optimality == Optimality::proved_best;
    const std::string reason = least.reason;
    restate(least);
    least.objective_start = first.objective_start;
    if (otherwise_done) {
      least.status = proved ? DesignStatus::impossible : DesignStatus::compromise;
      least.proved = proved;
    }
    if (proved) least.least_violation = bound;
    least.reason = (otherwise_done || reason.empty() ? "" : reason + "; ") + complaint(least, proved, best);
    return least;
  }

  std::string complaint(const DesignOutcome& outcome, bool proved, bool best) const {
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

DesignOutcome solve(const DesignProblem& problem) {
  problem.search.validate();
  if (problem.goals.empty() && !problem.objective && problem.limits.empty())
    throw std::invalid_argument("a design needs a goal, something to minimize or limits");
  if (is_discrete(problem)) return solve_discrete(problem);
  const auto search = [](const DesignProblem& one) {
    return one.limits.empty() ? pass_once(one).outcome : LimitedDesign(one).run();
  };
  DesignOutcome outcome = search(problem);
  bound_by_relaxation(problem, outcome, search);
  return outcome;
}

}  // namespace balance
