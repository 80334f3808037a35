#include "balance/synthesis/design/discrete_design.hpp"

#include "balance/foundation/base/spelling.hpp"
#include "balance/synthesis/design/branch_and_bound.hpp"
#include "balance/synthesis/design/derived_problems.hpp"
#include "balance/synthesis/design/problem_functions.hpp"
#include "balance/synthesis/design/size_search.hpp"
#include "balance/synthesis/design/solution_analysis.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>

namespace balance::design {

namespace {

using Rank = DiscreteCandidate::Rank;

/// Minimum time for solving the final design again, even if the search has used up its time [s].
constexpr double min_final_search_seconds = 0.2;
/// For work that is not a search [s].
constexpr double unlimited_seconds = 1e9;
/// Number of combinations above which branch and bound is faster if there are bounds.
constexpr long max_unbounded_combinations = 2000;
/// Number of combinations along a known motion that take as long as a motion.
constexpr long max_cheap_combinations_factor = 50;
/// Relative difference below which two figures count as equal.
constexpr double equal_figure_tolerance = 1e-9;

/// A model whose conditions do not depend on the free numbers and are derived only once.
class SharedConditionsModel final : public DesignModelDecorator {
 public:
  SharedConditionsModel(std::shared_ptr<const DesignModel> model, Conditions conditions)
      : DesignModelDecorator(std::move(model)), conditions_(std::move(conditions)) {}

  Conditions derive_conditions(const Mechanism& /*mechanism*/, const std::vector<Goal>& /*goals*/,
                               const ConditionOptions& /*options*/) const override {
    return conditions_;
  }

 private:
  Conditions conditions_;
};

class DiscreteDesign {
 public:
  explicit DiscreteDesign(const DesignProblem& problem)
      : problem_(problem),
        budget_(problem.search.max_time, problem.on_progress),
        bounds_(problem_),
        search_(problem_, budget_, bounds_, node_counts_) {
    problem_.on_progress = [this](const SearchProgress&) { return !budget_.is_interrupted(); };
    if (const Conditions* conditions = bounds_.shared_conditions(BranchingRule(problem_, 0).root());
        conditions != nullptr)
      problem_.model = std::make_shared<const SharedConditionsModel>(problem_.model, *conditions);
  }

  DesignOutcome run() {
    if (is_finite(problem_)) {
      const SizeSearchResult sizes = search_sizes();
      if (sizes.x.size() > 0 || sizes.is_exhausted) return make_size_outcome(sizes);
    }
    const int element_count = BranchingRule::count_unrestricted_elements(problem_);
    BranchAndBoundResult result = element_count > 0
                                      ? minimise_element_count(element_count)
                                      : search_.run(BranchingRule(problem_, 0), BranchObjective::constrained_figure);
    if (result.incumbent && result.incumbent->rank == Rank::exact) return make_exact_outcome(std::move(result));
    const bool is_proved_infeasible = result.is_exhausted && !budget_.stopped;
    std::string explanation =
        element_count > 0 || problem_.cardinality_constraints.empty() ? "" : explain_required_count();
    BranchAndBoundResult compromise = search_compromise(std::move(result), element_count);
    if (!compromise.incumbent) return make_failed_outcome();
    return make_compromise_outcome(std::move(compromise), is_proved_infeasible, std::move(explanation));
  }

 private:
  /// If all variables have sizes: tries all combinations or, if there are too many, as many as the search may evaluate.
  /// @return no design if branch and bound is to decide
  SizeSearchResult search_sizes() {
    const SolverContext& context = full_context();
    const std::vector<int> lengths = geometric_variables(context);
    std::vector<int> all = inertial_variables(context);
    const bool has_motion_per_length = !lengths.empty() && !all.empty();
    all.insert(all.end(), lengths.begin(), lengths.end());
    const long max_motions = problem_.search.max_evaluations;
    const bool is_cheap = has_motion_per_length || has_functions_of_parameters();
    const long max_combinations = is_cheap ? max_cheap_combinations_factor * max_motions : max_motions;
    const long combinations = count_combinations(problem_, all, max_combinations + 1);
    if (combinations > max_unbounded_combinations && has_bounded_figure()) return {};
    const bool can_try_all =
        combinations <= max_combinations &&
        (!has_motion_per_length || count_combinations(problem_, lengths, max_motions + 1) <= max_motions);
    return can_try_all ? try_all_sizes(problem_, budget_) : exchange_sizes(problem_, budget_, max_combinations);
  }

  /// Whether the relaxation of all designs bounds the figure.
  bool has_bounded_figure() {
    return (!problem_.objective || problem_.model->capabilities().has_convex_terms) &&
           bounds_.shared_conditions(BranchingRule(problem_, 0).root()) != nullptr;
  }

  bool has_functions_of_parameters() const {
    return (!problem_.objective || problem_.objective->is_of_parameters()) &&
           std::all_of(problem_.limits.begin(), problem_.limits.end(),
                       [](const DesignLimit& limit) { return limit.figure.is_of_parameters(); });
  }

  /// Finds the minimum number of elements for which there is an exact design.
  BranchAndBoundResult minimise_element_count(int element_count) {
    BranchAndBoundResult result;
    selection_.is_min_count_proved = true;
    for (int count = 0; count <= element_count; ++count) {
      result = search_.run(BranchingRule(problem_, count), BranchObjective::constrained_figure);
      if (result.incumbent && result.incumbent->rank == Rank::exact) {
        selection_.min_count = count;
        return result;
      }
      selection_.is_min_count_proved = selection_.is_min_count_proved && result.is_exhausted && !budget_.stopped;
      if (budget_.stopped) break;
    }
    return result;
  }

  /// If the requested number of elements is insufficient: explains how many are needed.
  std::string explain_required_count() {
    DesignProblem unrestricted = problem_;
    for (CardinalityConstraint& choice : unrestricted.cardinality_constraints) choice.max_count = -1;
    unrestricted.objective.reset();
    const int element_count = BranchingRule::count_unrestricted_elements(unrestricted);
    BranchAndBound search(unrestricted, budget_, bounds_, node_counts_);
    bool proved = true;
    int requested_count = 0;
    for (const CardinalityConstraint& choice : problem_.cardinality_constraints)
      requested_count += std::max(0, choice.max_count);
    for (int count = 0; count <= element_count && !budget_.is_spent(); ++count) {
      const BranchAndBoundResult result =
          search.run(BranchingRule(unrestricted, count), BranchObjective::constrained_figure);
      proved = proved && (result.is_exhausted || result.incumbent) && !budget_.stopped;
      if (!result.incumbent || result.incumbent->rank != Rank::exact) continue;
      selection_.min_count = count;
      selection_.is_min_count_proved = proved;
      return fmt::format("no set of {} {}; a set of {} does{}", describe_kinds(requested_count), requirement_phrase(),
                         count, proved ? ", and none smaller" : "");
    }
    return proved && !budget_.stopped
               ? fmt::format("no set of {} {}, nor does the set of all {}", describe_kinds(requested_count),
                             requirement_phrase(), element_count)
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

  /// If there is no exact design: finds the best approximation.
  BranchAndBoundResult search_compromise(BranchAndBoundResult exact_result, int element_count) {
    const BranchingRule branching(problem_, element_count);
    if (exact_result.incumbent && exact_result.incumbent->rank == Rank::limits_violated) return exact_result;
    const BranchObjective target =
        problem_.objective && !problem_.objective->is_secondary ? BranchObjective::figure : BranchObjective::residual;
    BranchAndBoundResult compromise = search_.run(branching, target);
    if (exact_result.incumbent &&
        (!compromise.incumbent || exact_result.incumbent->value < compromise.incumbent->value))
      compromise.incumbent = std::move(exact_result.incumbent);
    if (!compromise.incumbent && budget_.stopped)
      compromise.incumbent = search_.solve_first_leaf(branching, target, min_final_search_seconds);
    return compromise;
  }

  /// The outcome of a search over combinations of sizes.
  DesignOutcome make_size_outcome(const SizeSearchResult& sizes) {
    combinations_ = sizes;
    if (sizes.x.size() == 0) return make_failed_size_outcome();
    DiscreteCandidate candidate;
    candidate.rank = std::min(sizes.rating.rank, Rank::conditions_violated);
    candidate.value = sizes.rating.value;
    candidate.outcome = evaluate_design(sizes.x);
    BranchAndBoundResult result;
    result.is_exhausted = sizes.is_exhausted;
    result.lower_bound = sizes.is_exhausted   ? candidate.value
                         : problem_.objective ? problem_.objective->lower_bound
                                              : -std::numeric_limits<double>::infinity();
    result.incumbent = std::move(candidate);
    if (result.incumbent->rank == Rank::exact) return make_exact_outcome(std::move(result));
    return make_compromise_outcome(std::move(result), sizes.is_exhausted, "");
  }

  DesignOutcome make_failed_size_outcome() {
    DesignOutcome outcome = evaluate_design(start_values(problem_));
    const std::string reason = outcome.reason;
    outcome.status = DesignStatus::unsolved;
    outcome.reason = fmt::format("none of the {} combinations of sizes gives a design{}", combinations_->combinations,
                                 reason.empty() ? "" : "; with the start values: " + reason);
    return outcome;
  }

  /// The outcome of a single design.
  DesignOutcome evaluate_design(const VectorX& x) const {
    BranchNode point;
    point.lower = point.upper = x;
    return solve_design(restrict_to_node(problem_, point, unlimited_seconds));
  }

  /// Among designs with the same figure, those with fewer elements are better.
  void drop_useless_elements(DiscreteCandidate& design) {
    if (!problem_.objective) return;
    const BranchingRule branching(problem_, 0);
    for (std::size_t k = 0; k < branching.element_count() && !budget_.is_spent(); ++k) {
      BranchNode node = branching.node_of(design.outcome.x);
      if (!branching.exclude(node, k)) continue;
      std::optional<DiscreteCandidate> smaller = search_.solve_node(std::move(node), equal_figure_bound(design.value));
      if (!smaller || smaller->rank != Rank::exact || smaller->value > equal_figure_bound(design.value)) continue;
      design = std::move(*smaller);
    }
  }
  static double equal_figure_bound(double value) { return value + equal_figure_tolerance * std::abs(value); }

  /// Solves for the best design again, to obtain its full outcome.
  /// @param lower_bound of the figure, minus infinity if unknown
  DesignOutcome solve_incumbent_again(const DiscreteCandidate& design, double lower_bound) {
    if (combinations_) return complete_outcome(design.outcome);
    DesignProblem restricted = restrict_to_node(problem_, BranchingRule(problem_, 0).node_of(design.outcome.x),
                                                std::max(min_final_search_seconds, budget_.remaining_time()));
    set_start(restricted, design.outcome.x);
    restricted.proved_lower_bound = lower_bound;
    DesignOutcome outcome = solve_design(restricted);
    const bool worse = outcome.status != design.outcome.status ||
                       !(outcome.within_limits == design.outcome.within_limits) ||
                       (problem_.objective && outcome.objective > equal_figure_bound(design.outcome.objective));
    if (worse) outcome = design.outcome;
    return complete_outcome(std::move(outcome));
  }

  /// Adds what refers to all variables and to their start values.
  DesignOutcome complete_outcome(DesignOutcome outcome) {
    const bool has_conditions = outcome.conditions.status == ConditionsStatus::done && !problem_.goals.empty();
    if (combinations_ && has_conditions) complete_conditions(outcome);
    const VectorX start = start_values(problem_);
    if (problem_.objective) outcome.start_objective = evaluate_figure(problem_, *problem_.objective, start);
    if (std::abs(outcome.objective) <= relative_figure_round_off * std::abs(outcome.start_objective))
      outcome.objective = 0;
    return outcome;
  }

  void complete_conditions(DesignOutcome& outcome) {
    const SolverContext& context = full_context();
    const Conditions at_start =
        context.classification.has_geometric() ? context.conditions_at(context.scaling.start()) : outcome.conditions;
    const bool has_same_pivots =
        at_start.status == ConditionsStatus::done && at_start.pivots == outcome.conditions.pivots;
    outcome.residuals_before = scaled_residuals(
        has_same_pivots ? at_start : outcome.conditions,
        conditions::term_values(context.mechanism(context.scaling.start()), context.options.loose_springs));
    outcome.condition_variables =
        find_condition_variables(context, outcome.conditions, context.scaling.to_unit(outcome.x));
    std::erase_if(outcome.unmet_fixed_conditions,
                  [&](int row) { return !outcome.condition_variables[static_cast<std::size_t>(row)].empty(); });
    const bool has_variables = std::any_of(outcome.condition_variables.begin(), outcome.condition_variables.end(),
                                           [](const std::vector<int>& variables) { return !variables.empty(); });
    if (!has_variables) return;
    if (outcome.method == DesignMethod::none)
      outcome.method = context.classification.has_geometric() ? DesignMethod::geometric : DesignMethod::affine;
    if (outcome.status == DesignStatus::balanced) determine_status(outcome);
  }

  /// All variables within their bounds, without sizes.
  const SolverContext& full_context() {
    if (!full_context_) full_context_ = std::make_unique<const SolverContext>(problem_, context_budget_);
    return *full_context_;
  }

  std::string search_summary() const {
    if (!combinations_)
      return count_noun(node_counts_.branches, "branch", "branches") + ", " +
             count_noun(node_counts_.designs, "design", "designs");
    std::string text = count_noun(combinations_->combinations, "combination", "combinations") + " of sizes";
    if (combinations_->is_exhausted) text = "all " + text;
    if (budget_.local_searches > 0) text += ", " + count_noun(budget_.local_searches, "search", "searches");
    return text;
  }

  void record_effort(DesignOutcome& outcome, bool proved, bool is_optimised) const {
    outcome.search_summary = search_summary();
    outcome.effort = {};
    outcome.effort.local_searches = combinations_ ? budget_.local_searches : node_counts_.designs;
    outcome.effort.evaluations = combinations_ ? budget_.evaluations : node_counts_.branches;
    if (combinations_) outcome.effort.geometries = budget_.geometries;
    if (combinations_ && combinations_->rating.rank == DesignRating::Rank::exact) outcome.effort.ends = budget_.ends;
    if (combinations_) outcome.effort.combinations = combinations_->combinations;
    if (combinations_) outcome.effort.tried_all_combinations = combinations_->is_exhausted;
    using End = SearchEffort::Termination;
    outcome.effort.termination = proved            ? End::proved
                                 : budget_.stopped ? End::time_limit
                                 : is_optimised    ? End::starts_exhausted
                                                   : End::goal_met;
    outcome.optimality = !is_optimised     ? Optimality::not_optimised
                         : proved          ? Optimality::proved_global
                         : budget_.stopped ? Optimality::budget_exhausted
                                           : Optimality::local_optimum;
    if (problem_.cardinality_constraints.empty()) return;
    outcome.selection = selection_;
    outcome.selection->kept = BranchingRule(problem_, 0).kept_elements(outcome.x);
  }

  DesignOutcome make_exact_outcome(BranchAndBoundResult result) {
    drop_useless_elements(*result.incumbent);
    DesignOutcome outcome = solve_incumbent_again(*result.incumbent, result.lower_bound);
    const double value = problem_.objective ? outcome.objective : 0;
    const double bound = std::min(result.lower_bound, value);
    const bool proved = problem_.objective && bound >= value - relative_gap_tolerance * std::abs(value);
    outcome.lower_bound = problem_.objective && std::isfinite(bound) ? bound : std::numeric_limits<double>::quiet_NaN();
    record_effort(outcome, proved, problem_.objective.has_value());
    return outcome;
  }

  /// @param is_proved_infeasible whether it is proved that there is no exact design
  DesignOutcome make_compromise_outcome(BranchAndBoundResult result, bool is_proved_infeasible,
                                        std::string explanation) {
    const bool violates_limits = result.incumbent->rank == Rank::limits_violated;
    DesignOutcome outcome = solve_incumbent_again(*result.incumbent, -std::numeric_limits<double>::infinity());
    if (problem_.goals.empty() && !violates_limits) return make_exact_outcome(std::move(result));
    const bool by_figure = problem_.objective && !problem_.objective->is_secondary;
    const bool proved =
        (!violates_limits || combinations_) &&
        result.lower_bound >= result.incumbent->value - relative_gap_tolerance * std::abs(result.incumbent->value);
    outcome.lower_bound = by_figure && outcome.within_limits && std::isfinite(result.lower_bound)
                              ? std::min(result.lower_bound, outcome.objective)
                              : std::numeric_limits<double>::quiet_NaN();
    outcome.status = is_proved_infeasible ? DesignStatus::infeasible : DesignStatus::compromise;
    outcome.is_proved_infeasible = is_proved_infeasible;
    if (!violates_limits) outcome.reason = reason(is_proved_infeasible, std::move(explanation), outcome);
    if (violates_limits && combinations_) {
      outcome.reason = violation_reason(is_proved_infeasible, outcome);
      outcome.min_violation_bound = proved ? result.lower_bound : std::numeric_limits<double>::quiet_NaN();
    }
    record_effort(outcome, proved, true);
    return outcome;
  }

  /// Why no combination of sizes that was tried keeps the limits.
  std::string violation_reason(bool is_proved_infeasible, const DesignOutcome& outcome) const {
    return fmt::format(
        "{} all limits{}: {}{}",
        is_proved_infeasible ? "no combination of sizes keeps" : "no combination of sizes was found that keeps",
        problem_.goals.empty() ? "" : " and meets the conditions",
        describe_worst_limit(problem_.limits, outcome.limits),
        is_proved_infeasible ? ", the least possible for the worst limit" : "");
  }

  std::string reason(bool is_proved_infeasible, std::string explanation, DesignOutcome& outcome) {
    if (combinations_ && full_context().classification.has_geometric())
      return is_proved_infeasible ? "no combination of sizes meets the conditions"
                                  : "no combination of sizes was found that meets the conditions";
    const BranchNode root = BranchingRule(problem_, 0).root();
    const DesignOutcome continuous_outcome =
        solve_design(restrict_to_node(problem_, root, std::max(min_final_search_seconds, budget_.remaining_time())));
    if (continuous_outcome.status == DesignStatus::infeasible) {
      outcome.certificate = continuous_outcome.certificate;
      return continuous_outcome.reason;
    }
    outcome.certificate.reset();
    if (!explanation.empty()) return explanation;
    if (!is_proved_infeasible) return "no design was found that meets the conditions";
    if (problem_.cardinality_constraints.empty() && !problem_.all_different.empty())
      return "no combination of different sizes meets the conditions";
    return problem_.cardinality_constraints.empty()
               ? "no combination of sizes meets the conditions; sizes between them would"
               : "no combination of sizes and elements meets the conditions";
  }

  DesignOutcome make_failed_outcome() {
    DesignOutcome outcome = solve_design(restrict_to_node(
        problem_, BranchingRule(problem_, 0).root(), std::max(min_final_search_seconds, budget_.remaining_time())));
    if (outcome.status == DesignStatus::unsolved) return outcome;
    outcome.status = DesignStatus::unsolved;
    outcome.reason =
        budget_.stopped ? "the time ran out before a design was found" : "no combination of sizes gives a design";
    return outcome;
  }

  DesignProblem problem_;
  SearchBudget budget_;
  SearchBudget context_budget_{unlimited_seconds};          ///< of what is computed before and after a search
  std::unique_ptr<const SolverContext> full_context_ = {};  ///< empty until it is needed
  std::optional<SizeSearchResult> combinations_;            ///< if all variables have sizes
  NodeCounts node_counts_;
  NodeBounds bounds_;
  BranchAndBound search_;
  ElementSelection selection_;
};

}  // namespace

bool is_discrete(const DesignProblem& problem) {
  return !problem.cardinality_constraints.empty() ||
         std::any_of(problem.variables.begin(), problem.variables.end(),
                     [](const DesignVariable& v) { return !v.discrete_values.empty(); });
}

DesignOutcome solve_discrete(const DesignProblem& problem) { return DiscreteDesign(problem).run(); }

}  // namespace balance::design
