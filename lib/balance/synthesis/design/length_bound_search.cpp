#include "balance/synthesis/design/length_bound_search.hpp"

#include "balance/foundation/base/cpu_time.hpp"
#include "balance/synthesis/design/derived_problems.hpp"
#include "balance/synthesis/design/solution_analysis.hpp"

#include <algorithm>
#include <cmath>

namespace balance::design {

namespace {

/// Part of the time of a design for the bound before the search, and its limit [s].
constexpr double first_time_fraction = 0.2, max_first_seconds = 3;
/// Part of the remaining time for the search where the bound is not reached.
constexpr double search_time_fraction = 0.5;
/// Time to find a compromise where no lengths meet the conditions [s].
constexpr double max_compromise_seconds = 2;
/// Time that the bound may take after a short search [s].
constexpr double min_second_seconds = 3;
/// Time for the masses at lengths that the bound found, even if the others have used up theirs [s].
constexpr double min_completion_seconds = 1;
constexpr long max_bounded_boxes = 20'000;
/// Relative: the bound is not raised any more.
constexpr double closed_gap = 1e-8;
/// Relative: a design that is lighter than the bound by more is of a geometry that it does not cover.
constexpr double refutation_tolerance = 1e-6;

/// The spec's request with what the options replace.
DesignSpace requested_space(const DesignSpace& space, const DesignStudyOptions& options) {
  DesignSpace requested = space;
  if (!options.goals.empty()) requested.start.design.goals = options.goals;
  if (!options.minimize.empty()) {
    requested.start.design.minimize = options.minimize;
    requested.start.design.front = {};
  }
  return requested;
}

/// Why lengths are not bounded; empty: they may be.
/// @param requested with what the options replace
std::string find_obstacle(const DesignSpace& requested, const DesignStudyOptions& options) {
  const auto& numbers = requested.start.free_numbers;
  if (options.is_modular) return "the conditions are those of the modular strategy";
  if (!options.excluded.empty()) return "parts of the mechanism are left out";
  if (std::any_of(numbers.begin(), numbers.end(), [](const FreeNumber& n) { return !n.discrete_values.empty(); }))
    return "free numbers have sizes";
  const certificate::LinkageReading reading = certificate::read_linkage(requested);
  if (reading.linkage && !certificate::has_free_lengths(*reading.linkage)) return "no length is free";
  return reading.reason;
}

/// The bound and the search in turns, within the time of the design.
class BoundedSearch {
 public:
  BoundedSearch(const DesignSpace& space, const DesignProblem& problem, bool keeps_proof)
      : problem_(problem),
        judge_(make_length_design_judge(space)),
        bound_(space, *judge_, bound_options(space, keeps_proof)),
        start_time_(thread_cpu_time()) {}

  DesignOutcome solve() {
    raise_bound(std::min(max_first_seconds, first_time_fraction * problem_.search.max_time));
    if (const LengthBound first = bound_.result(); has_closed_gap(first)) {
      DesignOutcome outcome = solve_at_lengths(first.design);
      if (is_design(outcome) && outcome.objective <= first.best * (1 + closed_gap)) return outcome;
    }
    DesignOutcome outcome = search();
    const LengthBound last = bound_.result();
    if (last.design.size() == 0 || (is_design(outcome) && outcome.objective <= last.best * (1 + closed_gap)))
      return outcome;
    DesignOutcome lighter = solve_at_lengths(last.design);
    if (!is_design(lighter) || (is_design(outcome) && !(lighter.objective < outcome.objective))) return outcome;
    lighter.effort = outcome.effort;
    lighter.search_summary = outcome.search_summary;
    lighter.optimality = outcome.optimality;
    return lighter;
  }

  LengthBound bound() const { return bound_.result(); }

 private:
  static LengthBoundOptions bound_options(const DesignSpace& space, bool keeps_proof) {
    LengthBoundOptions options;
    options.max_nodes = max_bounded_boxes;
    options.gap_tolerance = closed_gap;
    options.required_trajectories = list_followed_trajectories(space);
    options.keeps_proof = keeps_proof;
    return options;
  }

  static bool has_closed_gap(const LengthBound& bound) {
    return bound.reason.empty() && bound.design.size() > 0 && bound.gap() <= closed_gap;
  }

  double elapsed() const { return thread_cpu_time() - start_time_; }
  double remaining() const { return std::max(0.0, problem_.search.max_time - elapsed()); }

  void raise_bound(double seconds) {
    const double end = elapsed() + seconds;
    bound_.run([&] {
      is_interrupted_ =
          is_interrupted_ || (problem_.on_progress && !problem_.on_progress({elapsed(), problem_.search.max_time}));
      return is_interrupted_ || elapsed() > end;
    });
  }

  /// Searches from the best lengths so far, and raises the bound in the time that is left.
  DesignOutcome search() {
    const LengthBound known = bound_.result();
    DesignProblem from_best = problem_;
    if (known.design.size() > 0) set_start(from_best, known.design);
    if (known.reason.empty() && std::isfinite(known.lower_bound)) from_best.proved_lower_bound = known.lower_bound;
    const bool is_decided = !known.reason.empty() || bound_.is_finished();
    from_best.search.max_time = known.is_impossible() ? std::min(remaining(), max_compromise_seconds)
                                : is_decided          ? remaining()
                                                      : search_time_fraction * remaining();
    from_best.search.max_time = std::max(from_best.search.max_time, 1e-3);
    const double before = elapsed();
    DesignOutcome outcome = solve_design(from_best);
    if (known.design.size() > 0) describe_start(outcome);
    if (is_decided) return outcome;
    if (is_design(outcome) && outcome.status == DesignStatus::balanced) bound_.add_design(outcome.x, outcome.objective);
    if (!is_interrupted_) raise_bound(std::min(remaining(), std::max(min_second_seconds, elapsed() - before)));
    return outcome;
  }

  /// The best masses at the lengths of x.
  DesignOutcome solve_at_lengths(const VectorX& x) const {
    DesignProblem fixed = problem_;
    fixed.search.max_time = std::max(remaining(), min_completion_seconds);
    fixed.is_subproblem = true;
    set_start(fixed, x);
    SearchBudget budget(fixed.search.max_time, problem_.on_progress);
    const SolverContext context(problem_, budget);
    for (const int i : geometric_variables(context)) {
      DesignVariable& length = fixed.variables[static_cast<std::size_t>(i)];
      length.lower = length.upper = length.start;
    }
    DesignOutcome outcome = solve_design(fixed);
    complete_design(problem_, std::max(remaining(), min_completion_seconds), outcome);
    describe_start(outcome);
    return outcome;
  }

  /// Replaces what refers to the start values.
  void describe_start(DesignOutcome& outcome) const {
    if (problem_.objective)
      outcome.start_objective = evaluate_figure(problem_, *problem_.objective, start_values(problem_));
    const Mechanism start = problem_.model->build_mechanism(start_values(problem_));
    const Conditions conditions = problem_.model->derive_conditions(start, problem_.goals, problem_.options);
    outcome.residuals_before = VectorX();
    if (conditions.status == ConditionsStatus::done && conditions.pivots == outcome.conditions.pivots)
      outcome.residuals_before = scaled_residuals(conditions, term_values(start, problem_.options.loose_springs));
  }

  const DesignProblem& problem_;
  std::unique_ptr<LengthDesignJudge> judge_;
  LengthBoundSearch bound_;
  double start_time_;
  bool is_interrupted_ = false;
};

/// @return whether the bound agrees with the outcome
bool apply_bound(const LengthBound& bound, DesignOutcome& outcome) {
  const bool has_design = is_design(outcome) && outcome.status == DesignStatus::balanced;
  if (bound.is_impossible()) {
    if (has_design) return false;
    if (outcome.status != DesignStatus::compromise) return true;
    outcome.status = DesignStatus::infeasible;
    outcome.is_proved_infeasible = true;
    outcome.reason = "no masses and places within the bounds of the free numbers meet the conditions, at any lengths";
    return true;
  }
  if (!has_design) return true;
  if (outcome.objective < bound.lower_bound * (1 - refutation_tolerance)) return false;
  raise_lower_bound(outcome, bound.lower_bound);
  return true;
}

}  // namespace

DesignOutcome solve_with_length_bound(const DesignSpace& space, const DesignStudyOptions& options,
                                      const DesignProblem& problem, std::optional<LengthBound>& bound) {
  const DesignSpace requested = requested_space(space, options);
  LengthBound found;
  found.reason = find_obstacle(requested, options);
  DesignOutcome outcome;
  if (found.reason.empty()) {
    BoundedSearch search(requested, problem, options.keeps_proof);
    outcome = search.solve();
    found = search.bound();
    if (found.reason.empty() && !apply_bound(found, outcome))
      found.reason = "a design was found that is lighter than its bound";
  } else {
    outcome = solve_design(problem);
  }
  if (found.reason.empty() || outcome.method == DesignMethod::geometric) bound = std::move(found);
  return outcome;
}

}  // namespace balance::design

namespace balance {

std::string find_certificate_obstacle(const DesignSpace& space, const DesignStudyOptions& options) {
  if (space.start.design.cases.size() > 0) return "there are load cases";
  const DesignSpace requested = design::requested_space(space, options);
  std::string obstacle = design::find_obstacle(requested, options);
  if (!obstacle.empty()) return obstacle;
  return certificate::list_length_geometries(requested, list_followed_trajectories(requested)).reason;
}

}  // namespace balance
