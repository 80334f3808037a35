#include "balance/synthesis/design/discrete_design.hpp"

#include "balance/foundation/base/spelling.hpp"
#include "balance/synthesis/design/branch_and_bound.hpp"
#include "balance/synthesis/design/derived_problems.hpp"
#include "balance/synthesis/design/problem_functions.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace balance::design {

namespace {

using Rank = DiscreteCandidate::Rank;

/// For the solution that a search ends with, where it has used up its time [s].
constexpr double min_final_search_seconds = 0.2;

class DiscreteDesign {
 public:
  explicit DiscreteDesign(const DesignProblem& problem)
      : problem_(problem),
        budget_(problem.search.max_time, problem.on_progress),
        bounds_(problem_),
        search_(problem_, budget_, bounds_, steps_) {
    problem_.on_progress = [this](const SearchProgress&) { return !budget_.is_interrupted(); };
    if (const Conditions* all = bounds_.shared_conditions(BranchingRule(problem_, 0).root()); all != nullptr)
      problem_.derive_conditions = [all = *all](const Mechanism&, const std::vector<Goal>&, const ConditionOptions&) {
        return all;
      };
  }

  DesignOutcome run() {
    const int offered = BranchingRule::count_unrestricted_elements(problem_);
    BranchAndBoundResult walk = offered > 0
                                    ? minimise_element_count(offered)
                                    : search_.run(BranchingRule(problem_, 0), BranchObjective::constrained_figure);
    if (walk.incumbent && walk.incumbent->rank == Rank::exact) return make_exact_outcome(std::move(walk));
    const bool none = walk.is_exhausted && !budget_.stopped;
    std::string why = offered > 0 || problem_.cardinality_constraints.empty() ? "" : explain_required_count();
    BranchAndBoundResult second = search_compromise(std::move(walk), offered);
    if (!second.incumbent) return make_failed_outcome();
    return make_compromise_outcome(std::move(second), none, std::move(why));
  }

 private:
  /// The least count with which there is an exact design.
  BranchAndBoundResult minimise_element_count(int offered) {
    BranchAndBoundResult walk;
    chosen_.is_min_count_proved = true;
    for (int count = 0; count <= offered; ++count) {
      walk = search_.run(BranchingRule(problem_, count), BranchObjective::constrained_figure);
      if (walk.incumbent && walk.incumbent->rank == Rank::exact) {
        chosen_.min_count = count;
        return walk;
      }
      chosen_.is_min_count_proved = chosen_.is_min_count_proved && walk.is_exhausted && !budget_.stopped;
      if (budget_.stopped) break;
    }
    return walk;
  }

  /// Some count was asked for that is not enough: how many would be.
  std::string explain_required_count() {
    DesignProblem free = problem_;
    for (CardinalityConstraint& choice : free.cardinality_constraints) choice.max_count = -1;
    free.objective.reset();
    const int offered = BranchingRule::count_unrestricted_elements(free);
    BranchAndBound search(free, budget_, bounds_, steps_);
    bool proved = true;
    int asked = 0;
    for (const CardinalityConstraint& choice : problem_.cardinality_constraints) asked += std::max(0, choice.max_count);
    for (int count = 0; count <= offered && !budget_.is_spent(); ++count) {
      const BranchAndBoundResult walk = search.run(BranchingRule(free, count), BranchObjective::constrained_figure);
      proved = proved && (walk.is_exhausted || walk.incumbent) && !budget_.stopped;
      if (!walk.incumbent || walk.incumbent->rank != Rank::exact) continue;
      chosen_.min_count = count;
      chosen_.is_min_count_proved = proved;
      return fmt::format("no choice of {} {}; {} of them do{}", describe_kinds(asked), requirement_phrase(), count,
                         proved ? ", and no fewer" : "");
    }
    return proved && !budget_.stopped ? fmt::format("no choice of {} {}, nor do all {} that are offered",
                                                    describe_kinds(asked), requirement_phrase(), offered)
                                      : "";
  }

  std::string describe_kinds(int count) const {
    std::string kinds;
    for (const CardinalityConstraint& choice : problem_.cardinality_constraints)
      kinds += (kinds.empty() ? "" : " and ") + choice.kind;
    return fmt::format("{} {}", count, kinds);
  }

  const char* requirement_phrase() const {
    return problem_.goals.empty() ? "keeps the limits" : "meets the conditions";
  }

  /// No exact design: what comes near to one.
  BranchAndBoundResult search_compromise(BranchAndBoundResult first, int offered) {
    const BranchingRule branching(problem_, offered);
    if (first.incumbent && first.incumbent->rank == Rank::limits_violated) return first;
    const BranchObjective wanted =
        problem_.objective && !problem_.objective->is_secondary ? BranchObjective::figure : BranchObjective::residual;
    BranchAndBoundResult second = search_.run(branching, wanted);
    if (first.incumbent && (!second.incumbent || first.incumbent->value < second.incumbent->value))
      second.incumbent = std::move(first.incumbent);
    return second;
  }

  /// The design once more, with all that is told of one.
  DesignOutcome solve_incumbent_again(const DiscreteCandidate& design) {
    BranchNode branch;
    branch.lower = branch.upper = design.outcome.x;
    for (std::size_t i = 0; i < problem_.variables.size(); ++i) {
      const auto k = static_cast<Eigen::Index>(i);
      const bool held =
          !problem_.variables[i].discrete_values.empty() || is_excluded(design.outcome.x, static_cast<int>(i));
      if (held) continue;
      branch.lower[k] = problem_.variables[i].lower;
      branch.upper[k] = problem_.variables[i].upper;
    }
    DesignProblem part =
        restrict_to_node(problem_, branch, std::max(min_final_search_seconds, budget_.remaining_time()));
    for (std::size_t i = 0; i < part.variables.size(); ++i)
      part.variables[i].start =
          std::clamp(design.outcome.x[static_cast<Eigen::Index>(i)], part.variables[i].lower, part.variables[i].upper);
    DesignOutcome outcome = solve_design(part);
    const bool worse = outcome.status != design.outcome.status ||
                       !(outcome.within_limits == design.outcome.within_limits) ||
                       (problem_.objective && outcome.objective > design.outcome.objective);
    if (worse) outcome = design.outcome;
    remove_fixed_variables(part, outcome.solution_set);
    const VectorX start = start_values();
    if (problem_.objective) outcome.start_objective = evaluate_figure(problem_, *problem_.objective, start);
    if (std::abs(outcome.objective) <= relative_figure_round_off * std::abs(outcome.start_objective))
      outcome.objective = 0;
    return outcome;
  }

  /// Numbers that are held change nothing, which is no freedom.
  static void remove_fixed_variables(const DesignProblem& part, SolutionSet& freedom) {
    const auto held = [&](int i) {
      const DesignVariable& variable = part.variables[static_cast<std::size_t>(i)];
      return variable.lower == variable.upper;
    };
    const int count =
        static_cast<int>(std::count_if(freedom.free_variables.begin(), freedom.free_variables.end(), held));
    std::erase_if(freedom.free_variables, held);
    if (freedom.dimension >= 0) freedom.dimension = std::max(0, freedom.dimension - count);
    if (freedom.optimal_dimension >= 0) freedom.optimal_dimension = std::max(0, freedom.optimal_dimension - count);
  }

  VectorX start_values() const {
    VectorX start(static_cast<Eigen::Index>(problem_.variables.size()));
    for (std::size_t i = 0; i < problem_.variables.size(); ++i)
      start[static_cast<Eigen::Index>(i)] = problem_.variables[i].start;
    return start;
  }

  bool is_excluded(const VectorX& x, int number) const {
    const auto kept = BranchingRule(problem_, 0).kept_elements(x);
    for (std::size_t c = 0; c < problem_.cardinality_constraints.size(); ++c)
      for (std::size_t k = 0; k < problem_.cardinality_constraints[c].elements.size(); ++k) {
        const std::vector<int>& numbers = problem_.cardinality_constraints[c].elements[k].variables;
        if (!kept[c][k] && std::find(numbers.begin(), numbers.end(), number) != numbers.end()) return true;
      }
    return false;
  }

  void record_effort(DesignOutcome& outcome, bool proved, bool asked) const {
    outcome.search_summary =
        count_noun(steps_.branches, "branch", "branches") + ", " + count_noun(steps_.designs, "design", "designs");
    outcome.effort = {};
    outcome.effort.local_searches = steps_.designs;
    outcome.effort.evaluations = steps_.branches;
    using End = SearchEffort::Termination;
    outcome.effort.termination = proved            ? End::proved
                                 : budget_.stopped ? End::time_limit
                                 : asked           ? End::starts_exhausted
                                                   : End::goal_met;
    outcome.optimality = !asked            ? Optimality::not_optimised
                         : proved          ? Optimality::proved_global
                         : budget_.stopped ? Optimality::budget_exhausted
                                           : Optimality::local_optimum;
    if (problem_.cardinality_constraints.empty()) return;
    outcome.selection = chosen_;
    outcome.selection->kept = BranchingRule(problem_, 0).kept_elements(outcome.x);
  }

  DesignOutcome make_exact_outcome(BranchAndBoundResult walk) {
    DesignOutcome outcome = solve_incumbent_again(*walk.incumbent);
    const double value = problem_.objective ? outcome.objective : 0;
    const double bound = std::min(walk.lower_bound, value);
    const bool proved = problem_.objective && bound >= value - relative_gap_tolerance * std::abs(value);
    outcome.lower_bound = problem_.objective && std::isfinite(bound) ? bound : std::numeric_limits<double>::quiet_NaN();
    record_effort(outcome, proved, problem_.objective.has_value());
    return outcome;
  }

  /// @param none it is shown that there is no exact design
  DesignOutcome make_compromise_outcome(BranchAndBoundResult walk, bool none, std::string why) {
    const bool beyond = walk.incumbent->rank == Rank::limits_violated;
    DesignOutcome outcome = solve_incumbent_again(*walk.incumbent);
    if (problem_.goals.empty() && !beyond) return make_exact_outcome(std::move(walk));
    const bool by_figure = problem_.objective && !problem_.objective->is_secondary;
    const bool proved =
        !beyond && walk.lower_bound >= walk.incumbent->value - relative_gap_tolerance * std::abs(walk.incumbent->value);
    outcome.lower_bound = by_figure && !beyond && std::isfinite(walk.lower_bound)
                              ? std::min(walk.lower_bound, outcome.objective)
                              : std::numeric_limits<double>::quiet_NaN();
    outcome.status = none ? DesignStatus::infeasible : DesignStatus::compromise;
    outcome.is_proved_infeasible = none;
    if (!beyond) outcome.reason = reason(none, std::move(why), outcome);
    record_effort(outcome, proved, true);
    return outcome;
  }

  std::string reason(bool none, std::string why, DesignOutcome& outcome) {
    const BranchNode all = BranchingRule(problem_, 0).root();
    const DesignOutcome plain =
        solve_design(restrict_to_node(problem_, all, std::max(min_final_search_seconds, budget_.remaining_time())));
    if (plain.status == DesignStatus::infeasible) {
      outcome.certificate = plain.certificate;
      return plain.reason;
    }
    outcome.certificate.reset();
    if (!why.empty()) return why;
    if (!none) return "no choice was found that meets the conditions";
    return problem_.cardinality_constraints.empty()
               ? "no choice of the sizes meets the conditions; sizes between them would"
               : "no choice of sizes and elements meets the conditions";
  }

  DesignOutcome make_failed_outcome() {
    DesignOutcome outcome = solve_design(restrict_to_node(
        problem_, BranchingRule(problem_, 0).root(), std::max(min_final_search_seconds, budget_.remaining_time())));
    if (outcome.status == DesignStatus::unsolved) return outcome;
    outcome.status = DesignStatus::unsolved;
    outcome.reason =
        budget_.stopped ? "the time ran out before a design was found" : "no choice of the sizes is a design";
    return outcome;
  }

  DesignProblem problem_;
  SearchBudget budget_;
  NodeCounts steps_;
  NodeBounds bounds_;
  BranchAndBound search_;
  ElementSelection chosen_;
};

}  // namespace

bool is_discrete(const DesignProblem& problem) {
  return !problem.cardinality_constraints.empty() ||
         std::any_of(problem.variables.begin(), problem.variables.end(),
                     [](const DesignVariable& v) { return !v.discrete_values.empty(); });
}

DesignOutcome solve_discrete(const DesignProblem& problem) { return DiscreteDesign(problem).run(); }

}  // namespace balance::design
