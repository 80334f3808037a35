#include "balance/synthesis/design/solve_design.hpp"

#include "balance/foundation/base/cpu_time.hpp"
#include "balance/foundation/base/error.hpp"
#include "balance/foundation/numerics/extrema.hpp"
#include "balance/synthesis/design/branch_and_bound.hpp"
#include "balance/synthesis/design/derived_problems.hpp"
#include "balance/synthesis/design/discrete_design.hpp"
#include "balance/synthesis/design/limit_relaxation.hpp"
#include "balance/synthesis/design/multistart.hpp"
#include "balance/synthesis/design/problem_functions.hpp"
#include "balance/synthesis/design/solution_analysis.hpp"
#include "balance/synthesis/design/solve_once.hpp"
#include "balance/synthesis/design/start_agreement.hpp"
#include "balance/synthesis/design/tie_breaking.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace balance::design {

// Bounds for designs whose conditions contain products of masses and positions.

/// In terms of masses and first moments, the problem is a convex relaxation. Its minimum is a lower bound for all
/// designs. If it cannot meet the conditions, no choice of the free numbers can.
/// @param search repeats the search from other start values
void bound_by_relaxation(const DesignProblem& problem, DesignOutcome& outcome,
                         const std::function<DesignOutcome(const DesignProblem&)>& search);

namespace {

bool is_bound_useful(const DesignProblem& problem, const DesignOutcome& outcome) {
  if (problem.is_subproblem || problem.is_modular || !outcome.within_limits) return false;
  const bool without_goal = outcome.status == DesignStatus::no_goal;
  if (outcome.method != DesignMethod::polynomial && !without_goal) return false;
  if (outcome.status == DesignStatus::compromise) return true;
  return problem.objective && problem.model->capabilities().has_convex_terms &&
         outcome.optimality == Optimality::local_optimum && (without_goal || outcome.status == DesignStatus::balanced);
}

void restart_from(const DesignProblem& problem, const VectorX& from, DesignOutcome& outcome,
                  const std::function<DesignOutcome(const DesignProblem&)>& search) {
  DesignProblem restarted_problem = problem;
  set_start(restarted_problem, from);
  DesignOutcome restarted = search(restarted_problem);
  if (restarted.status != outcome.status || !(restarted.objective < outcome.objective)) return;
  restarted.residuals_before = outcome.residuals_before;
  restarted.start_objective = outcome.start_objective;
  outcome = std::move(restarted);
}

}  // namespace

void bound_by_relaxation(const DesignProblem& problem, DesignOutcome& outcome,
                         const std::function<DesignOutcome(const DesignProblem&)>& search) {
  if (!is_bound_useful(problem, outcome)) return;
  const BranchingRule branching(problem, 0);
  const BranchNode root = branching.root();
  NodeBounds bounds(problem);
  const NodeBounds::Bound bound = bounds(root, branching.node_domain(root), BranchObjective::constrained_figure);
  if (!bound.has_relaxation) return;
  if (outcome.status == DesignStatus::compromise) {
    if (bound.is_feasible || !outcome.unmet_fixed_conditions.empty()) return;
    outcome.status = DesignStatus::infeasible;
    outcome.is_proved_infeasible = true;
    outcome.reason = "no masses and first moments within the bounds of the free numbers meet the conditions";
    return;
  }
  if (!std::isfinite(bound.lower_bound)) return;
  const double gap = outcome.objective - bound.lower_bound;
  if (gap > relative_gap_tolerance * std::abs(outcome.objective) && bound.x.size() > 0)
    restart_from(problem, bound.x, outcome, search);
  raise_lower_bound(outcome, bound.lower_bound);
}

namespace {

/// Whether one result of the same problem is better than another: balanced first, then within the limits or nearer to
/// them, then by the objective.
bool is_better(const DesignOutcome& one, const DesignOutcome& other) {
  const auto rank = [](const DesignOutcome& outcome) {
    const bool has_numbers =
        outcome.status != DesignStatus::unsolved && outcome.status != DesignStatus::no_feasible_start;
    return (has_numbers ? 1 : 0) + (has_numbers && outcome.within_limits ? 2 : 0) + (is_success(outcome) ? 4 : 0);
  };
  if (rank(one) != rank(other)) return rank(one) > rank(other);
  if (!one.within_limits && !other.within_limits && max_limit_violation(one) != max_limit_violation(other))
    return max_limit_violation(one) < max_limit_violation(other);
  return one.objective < other.objective;
}

/// Repeats a search from other starts, with other seeds, until enough starts agree or time or starts are used up. What
/// it does first does not depend on the time that is left, so that more time never gives a worse design.
class RepeatedSearch {
 public:
  using Search = std::function<DesignOutcome(const DesignProblem&)>;

  RepeatedSearch(const DesignProblem& problem, const Search& search)
      : problem_(problem), search_(search), start_time_(thread_cpu_time()) {}

  DesignOutcome run(DesignOutcome first) {
    best_ = std::move(first);
    complete_ends(best_.effort, best_);
    if (!is_repeatable()) return best_;
    const std::vector<VectorX> starts = low_discrepancy_points(
        problem_.search.max_restarts, static_cast<int>(problem_.variables.size()), problem_.search.seed);
    effort_ = best_.effort;
    for (std::size_t k = 0; k < starts.size() && !is_finished(); ++k) search_from(starts[k], k);
    best_.effort = effort_;
    if (best_.optimality == Optimality::local_optimum && is_interrupted_)
      best_.optimality = Optimality::budget_exhausted;
    using End = SearchEffort::Termination;
    best_.effort.termination = best_.optimality == Optimality::proved_global ? End::proved
                               : is_interrupted_                             ? End::time_limit
                               : agreement().is_reached()                    ? End::starts_agree
                                                                             : End::starts_exhausted;
    return best_;
  }

 private:
  bool is_repeatable() const {
    return !problem_.is_subproblem && !problem_.is_single_pass && problem_.objective &&
           best_.optimality == Optimality::local_optimum && std::isfinite(best_.objective);
  }
  StartAgreement agreement() const { return compare_starts(effort_.ends, best_.objective); }
  double remaining_time() const { return problem_.search.max_time - (thread_cpu_time() - start_time_); }
  bool is_finished() const {
    return is_interrupted_ || best_.optimality == Optimality::proved_global || agreement().is_reached() ||
           static_cast<int>(effort_.ends.size()) >= problem_.search.max_restarts;
  }

  /// A search without starts of its own is one start, and so is one that improved the end of a start.
  void complete_ends(SearchEffort& effort, const DesignOutcome& outcome) const {
    if (std::isfinite(outcome.objective) && compare_starts(effort.ends, outcome.objective).agreeing == 0)
      effort.ends.push_back(outcome.objective);
  }

  void search_from(const VectorX& u, std::size_t k) {
    if (!(remaining_time() > 0)) return void(is_interrupted_ = true);
    DesignProblem repeated = problem_;
    repeated.search.seed = problem_.search.seed + 1 + k;
    repeated.search.max_time = remaining_time();
    set_start(repeated, VariableScaling(problem_.variables).to_variables(u));
    if (problem_.on_progress)
      repeated.on_progress = [this](const SearchProgress& progress) { return report(progress); };
    DesignOutcome outcome;
    try {
      outcome = search_(repeated);
    } catch (const SpecError&) {  // an expression of the spec has no value at the start
      effort_.ends.push_back(std::numeric_limits<double>::quiet_NaN());
      return;
    }
    is_interrupted_ = outcome.optimality == Optimality::budget_exhausted;
    complete_ends(outcome.effort, outcome);
    if (is_success(outcome) != is_success(best_)) {
      // ends of compromises say nothing about balanced designs
      std::vector<double>& worse = is_better(outcome, best_) ? effort_.ends : outcome.effort.ends;
      std::fill(worse.begin(), worse.end(), std::numeric_limits<double>::quiet_NaN());
    }
    add(outcome.effort);
    const double bound = std::fmax(outcome.lower_bound, best_.lower_bound);
    if (is_better(outcome, best_)) replace_best(std::move(outcome));
    if (is_design(best_) && std::isfinite(bound)) raise_lower_bound(best_, bound);
  }

  void replace_best(DesignOutcome outcome) {
    outcome.start_objective = best_.start_objective;
    outcome.residuals_before =
        best_.residuals_before.size() == outcome.residuals_after.size() ? best_.residuals_before : VectorX();
    best_ = std::move(outcome);
  }

  void add(const SearchEffort& effort) {
    effort_.starts += effort.starts;
    effort_.local_searches += effort.local_searches;
    effort_.geometries += effort.geometries;
    effort_.evaluations += effort.evaluations;
    effort_.ends.insert(effort_.ends.end(), effort.ends.begin(), effort.ends.end());
  }

  bool report(const SearchProgress& progress) const {
    return problem_.on_progress({thread_cpu_time() - start_time_, problem_.search.max_time,
                                 effort_.starts + progress.starts, effort_.local_searches + progress.local_searches,
                                 effort_.geometries + progress.geometries, effort_.evaluations + progress.evaluations});
  }

  const DesignProblem& problem_;
  const Search& search_;
  double start_time_;
  DesignOutcome best_;
  SearchEffort effort_;  ///< of all passes
  bool is_interrupted_ = false;
};

/// Solves a design with limits. First searches from the start values. If this fails, or ends without a possible proof
/// of optimality, searches again from the design with the minimum violation of the limits (or the maximum margin).
class LimitedDesignSolver {
 public:
  explicit LimitedDesignSolver(const DesignProblem& problem) : problem_(problem), start_time_(thread_cpu_time()) {}

  DesignOutcome run() {
    if (problem_.goals.empty() && !problem_.objective) return solve_limits_only();
    SingleSolve first = solve_once(problem_);
    evaluate_limits(problem_, first.outcome);
    const DesignStatus status = first.outcome.status;
    if (is_single_design(problem_)) return describe_only_design(std::move(first.outcome));
    const bool is_solved = is_design(first.outcome);
    const bool is_proved = first.outcome.optimality == Optimality::proved_global || !first.is_convex;
    if ((is_solved && is_proved) || status == DesignStatus::unsolved || status == DesignStatus::no_feasible_start ||
        is_budget_exhausted(first))
      return first.outcome;
    DesignOutcome phase_one = solve_once(make_phase_one_problem(remaining(problem_))).outcome;
    evaluate_limits(problem_, phase_one);
    if (is_design(phase_one)) return choose_better(std::move(first.outcome), solve_from(std::move(phase_one)));
    if (is_solved || (!is_success(phase_one) && first.outcome.within_limits)) return first.outcome;
    if (phase_one.within_limits) return solve_from(std::move(phase_one));
    return make_violating_outcome(std::move(phase_one), first.outcome);
  }

 private:
  /// For problems with neither goal nor objective.
  DesignOutcome solve_limits_only() const {
    DesignOutcome outcome = solve_once(make_phase_one_problem(problem_)).outcome;
    evaluate_limits(problem_, outcome);
    if (outcome.status == DesignStatus::unsolved) return outcome;
    if (!outcome.within_limits) return make_violating_outcome(outcome, outcome);
    reset_objective(outcome);
    outcome.optimality = Optimality::not_optimised;
    return outcome;
  }

  DesignOutcome describe_only_design(DesignOutcome outcome) const {
    if (outcome.within_limits || outcome.status == DesignStatus::unsolved) return outcome;
    const DesignOutcome first = outcome;
    outcome.lower_bound = max_limit_violation(outcome);
    outcome.optimality = Optimality::proved_global;
    return make_violating_outcome(std::move(outcome), first);
  }

  /// Whether the budget ended the search although the limits are satisfied.
  bool is_budget_exhausted(const SingleSolve& pass) const {
    return pass.outcome.within_limits && pass.outcome.optimality == Optimality::budget_exhausted;
  }

  DesignProblem remaining(DesignProblem problem) const {
    problem.search.max_time = std::max(1e-3, problem.search.max_time - (thread_cpu_time() - start_time_));
    return problem;
  }

  /// Repeats the search from a design or a compromise within the limits; returns that one if this fails.
  DesignOutcome solve_from(DesignOutcome feasible) const {
    DesignProblem problem = remaining(problem_);
    set_start(problem, feasible.x);
    DesignOutcome second = solve_once(problem).outcome;
    evaluate_limits(problem_, second);
    if (is_design(second) || (second.within_limits && second.status == feasible.status)) return second;
    reset_objective(feasible);
    feasible.optimality = !problem_.objective                                 ? Optimality::not_optimised
                          : second.optimality == Optimality::budget_exhausted ? Optimality::budget_exhausted
                                                                              : Optimality::local_optimum;
    return feasible;
  }

  /// Replaces the results that refer to the violation by those of the objective.
  void reset_objective(DesignOutcome& outcome) const {
    outcome.lower_bound = outcome.objective = outcome.start_objective = std::numeric_limits<double>::quiet_NaN();
    outcome.solution_set = {};
    outcome.notes.clear();
    if (!problem_.objective) return;
    outcome.objective = evaluate_figure(problem_, *problem_.objective, outcome.x);
    outcome.start_objective = evaluate_figure(problem_, *problem_.objective, start_values(problem_));
  }

  /// @param first may be unusable or violate the limits
  static DesignOutcome choose_better(DesignOutcome first, DesignOutcome second) {
    second.start_objective = first.start_objective;
    second.residuals_before =
        first.residuals_before.size() == second.residuals_after.size() ? first.residuals_before : VectorX();
    const bool usable = is_design(first);
    if (!usable || second.optimality == Optimality::proved_global || second.objective < first.objective) return second;
    return first;
  }

  /// Outcome if no design satisfies the limits: the one with the minimum violation of the worst limit.
  DesignOutcome make_violating_outcome(DesignOutcome outcome, const DesignOutcome& first) const {
    const bool otherwise_done = is_success(outcome);
    const double bound = outcome.lower_bound;
    const bool proved = otherwise_done && bound > limit_tolerance;
    const bool best = outcome.optimality == Optimality::proved_global;
    const std::string reason = outcome.reason;
    reset_objective(outcome);
    outcome.start_objective = first.start_objective;
    if (otherwise_done) {
      outcome.status = proved ? DesignStatus::infeasible : DesignStatus::compromise;
      outcome.is_proved_infeasible = proved;
    }
    if (proved) outcome.min_violation_bound = bound;
    outcome.reason =
        (otherwise_done || reason.empty() ? "" : reason + "; ") + describe_violation(outcome, proved, best);
    return outcome;
  }

  std::string describe_violation(const DesignOutcome& outcome, bool proved, bool best) const {
    const std::string violation_text = describe_worst_limit(problem_.limits, outcome.limits);
    const char* condition_clause = problem_.goals.empty() ? "" : " and meet the conditions";
    if (std::any_of(outcome.limits.begin(), outcome.limits.end(),
                    [](const LimitOutcome& limit) { return !std::isfinite(limit.violation); }))
      return violation_text;
    if (proved)
      return fmt::format("no values of the free numbers keep all limits{}: {}{}", condition_clause, violation_text,
                         best ? ", the least possible for the worst limit" : "");
    return fmt::format("no values of the free numbers were found that keep all limits{}: {}", condition_clause,
                       violation_text);
  }

  const DesignProblem& problem_;
  double start_time_;
};

}  // namespace

namespace {

DesignOutcome solve_continuous(const DesignProblem& problem) {
  const auto search = [](const DesignProblem& one) {
    return one.limits.empty() ? solve_once(one).outcome : LimitedDesignSolver(one).run();
  };
  const auto solve = [&](const DesignProblem& one) {
    DesignOutcome outcome = search(one);
    bound_by_relaxation(one, outcome, search);
    return outcome;
  };
  const double start_time = thread_cpu_time();
  DesignOutcome outcome = problem.limits.empty() ? solve(problem) : solve_with_limits(problem, solve);
  DesignProblem rest = problem;
  rest.search.max_time = std::max(0.0, problem.search.max_time - (thread_cpu_time() - start_time));
  return RepeatedSearch(rest, search).run(std::move(outcome));
}

/// What is done with a design after every kind of search: ties are broken, what may still change is found, and bounds
/// that are known without a search are applied.
class DesignCompletion {
 public:
  /// @param seconds left for the search
  DesignCompletion(DesignProblem problem, double seconds)
      : problem_(std::move(problem)),
        budget_(std::max(seconds, min_time_fraction * problem_.search.max_time), problem_.on_progress),
        context_(problem_, budget_) {
    if (problem_.objective) objective_.emplace(context_, *problem_.objective);
  }

  void complete(DesignOutcome& outcome) {
    const bool is_balanced = is_success(outcome);
    const bool by_figure = objective_ && !problem_.objective->is_secondary && std::isfinite(outcome.objective);
    budget_.begin_search();
    if (objective_ && outcome.within_limits && (is_balanced || by_figure)) apply(outcome, break_ties(outcome));
    if (objective_ && !is_balanced && !by_figure) restore_ineffective(outcome);
    if (is_balanced && !budget_.is_interrupted())
      outcome.solution_set = analyse_solution_set(context_, objective_ ? &*objective_ : nullptr, outcome.conditions,
                                                  context_.scaling.to_unit(outcome.x));
    if (is_balanced) find_edges(outcome);
    budget_.finish_search();
    if (problem_.objective && outcome.lower_bound < problem_.objective->lower_bound)
      outcome.lower_bound = problem_.objective->lower_bound;
  }

 private:
  /// Step in unit coordinates, larger than the accuracy of the searches.
  static constexpr double edge_step = 2e-3;
  /// Time that is granted even if the search has used up its own.
  static constexpr double min_time_fraction = 0.02;

  VectorX break_ties(const DesignOutcome& outcome) const {
    return design::break_ties(context_, *objective_, outcome.conditions, context_.scaling.to_unit(outcome.x));
  }

  /// Numbers without effect on a compromise, which is chosen by its residuals, get their start values.
  void restore_ineffective(DesignOutcome& outcome) const {
    const auto residuals = [&](const VectorX& u) {
      return scaled_residuals(outcome.conditions,
                              conditions::term_values(context_.mechanism(u), context_.options.loose_springs));
    };
    VectorX u = context_.scaling.to_unit(outcome.x);
    for (int i = 0; i < context_.scaling.size(); ++i) {
      VectorX restored = u;
      restored[i] = context_.scaling.start()[i];
      if (restored[i] == u[i] || context_.classification.is_geometric[static_cast<std::size_t>(i)]) continue;
      const bool is_ineffective =
          numerics::max_abs(residuals(restored) - outcome.residuals_after) <= rounding_tolerance &&
          !((*objective_)(restored, nullptr) > outcome.objective);
      if (is_ineffective && context_.is_admissible(restored)) u = restored;
    }
    apply(outcome, u);
  }

  /// Tries slightly larger and smaller lengths.
  void find_edges(DesignOutcome& outcome) const {
    const VectorX u = context_.scaling.to_unit(outcome.x);
    for (int i = 0; i < context_.scaling.size(); ++i) {
      if (!context_.classification.is_geometric[static_cast<std::size_t>(i)] ||
          !problem_.variables[static_cast<std::size_t>(i)].discrete_values.empty())
        continue;
      for (const double step : {edge_step, -edge_step}) {
        VectorX moved = u;
        moved[i] += step;
        if (std::abs(moved[i]) > 1 || context_.budget.is_spent()) continue;
        if (std::string reason = context_.infeasibility_reason(moved); !reason.empty() && !context_.budget.stopped)
          outcome.edges.push_back({i, step > 0, std::move(reason)});
      }
    }
  }

  /// Replaces the numbers of a design by those of an equal one.
  void apply(DesignOutcome& outcome, const VectorX& u) const {
    const VectorX x = context_.scaling.to_variables(u);
    bool is_changed = false, is_geometry_changed = false;
    for (int i = 0; i < context_.scaling.size(); ++i) {
      const bool differs = std::abs(x[i] - outcome.x[i]) > rounding_tolerance * context_.scaling.half_width()[i];
      is_changed = is_changed || differs;
      is_geometry_changed =
          is_geometry_changed || (differs && context_.classification.is_geometric[static_cast<std::size_t>(i)]);
    }
    if (!is_changed) return;
    if (is_geometry_changed) {
      const Conditions conditions = context_.conditions_at(u);
      if (conditions.status != ConditionsStatus::done || conditions.pivots != outcome.conditions.pivots) return;
      outcome.conditions = conditions;
    }
    outcome.x = x;
    const double value = (*objective_)(u, nullptr);
    outcome.objective = std::abs(value) <= objective_->round_off() ? 0 : value;
    outcome.lower_bound = std::min(outcome.lower_bound, outcome.objective);
    outcome.residuals_after = scaled_residuals(
        outcome.conditions, conditions::term_values(context_.mechanism(u), context_.options.loose_springs));
    if (!problem_.limits.empty()) evaluate_limits(problem_, outcome);
  }

  /// Differences below this, relative to the range, are the round-off of unit coordinates.
  static constexpr double rounding_tolerance = 1e-14;

  const DesignProblem problem_;
  SearchBudget budget_;
  SolverContext context_;
  std::optional<ScaledObjective> objective_;
};

}  // namespace

void complete_design(const DesignProblem& problem, double seconds, DesignOutcome& outcome) {
  if (problem.is_subproblem || outcome.x.size() == 0 || outcome.status == DesignStatus::unsolved ||
      outcome.status == DesignStatus::no_feasible_start)
    return;
  if (!is_discrete(problem)) {
    DesignCompletion(problem, seconds).complete(outcome);
    return;
  }
  // sizes and choices stay as they were decided
  const BranchingRule branching(problem, 0);
  DesignCompletion(restrict_to_node(problem, branching.node_of(outcome.x), problem.search.max_time), seconds)
      .complete(outcome);
  if (outcome.selection) outcome.selection->kept = branching.kept_elements(outcome.x);
}

DesignOutcome solve_design(const DesignProblem& problem) {
  problem.search.validate();
  if (problem.goals.empty() && !problem.objective && problem.limits.empty())
    throw std::invalid_argument("a design needs a goal, something to minimize or limits");
  const double start_time = thread_cpu_time();
  DesignOutcome outcome = is_discrete(problem) ? solve_discrete(problem) : solve_continuous(problem);
  complete_design(problem, problem.search.max_time - (thread_cpu_time() - start_time), outcome);
  return outcome;
}

}  // namespace balance::design
