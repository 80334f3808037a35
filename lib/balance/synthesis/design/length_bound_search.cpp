#include "balance/synthesis/design/length_bound_search.hpp"

#include "balance/synthesis/design/assembly_continuation.hpp"
#include "balance/synthesis/design/derived_problems.hpp"
#include "balance/synthesis/design/figure_bound_search.hpp"
#include "balance/synthesis/design/search_budget.hpp"
#include "balance/synthesis/design/solution_analysis.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace balance::design {

using certificate::LengthBound;

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
/// Time to find how many elements are needed, where the requested number is too small [s].
constexpr double max_count_seconds = 1;
/// Part of the time for designs in other assembly modes, and its limit [s].
constexpr double other_mode_fraction = 0.2, max_other_mode_seconds = 4;
/// Relative: by how much a design in another assembly mode must be lighter to be named.
constexpr double min_mode_gain = 1e-4;
constexpr const char* no_free_length = "no length is free";
constexpr long max_bounded_boxes = 20'000;
/// Relative: the bound is not raised any more, and a design that is as near to it is the answer.
constexpr double closed_gap = 1e-8, reached_gap = 1e-7;
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
  if (options.is_modular) return "the conditions are those of the modular strategy";
  if (!options.excluded.empty()) return "parts of the mechanism are left out";
  // moments count where nothing else does: they need more than forces do
  const certificate::LinkageReading reading =
      certificate::read_linkage(requested, {}, !certificate::requires_force_or_static_balance(requested));
  if (reading.linkage && !certificate::has_free_lengths(*reading.linkage)) return no_free_length;
  return reading.reason;
}

double other_mode_seconds(const DesignProblem& problem) {
  return std::min(max_other_mode_seconds, other_mode_fraction * problem.search.max_time);
}

std::vector<certificate::ElementChoice> list_choices(const DesignProblem& problem) {
  std::vector<certificate::ElementChoice> choices;
  for (const CardinalityConstraint& constraint : problem.cardinality_constraints) {
    certificate::ElementChoice choice{{}, constraint.max_count};
    for (const OptionalElement& element : constraint.elements)
      choice.elements.push_back({element.variables, element.own_variables});
    choices.push_back(std::move(choice));
  }
  return choices;
}

/// The bound and the search in turns, within the time of the design.
class BoundedSearch {
 public:
  BoundedSearch(const DesignSpace& space, const DesignProblem& problem, bool keeps_certificates)
      : space_(space),
        problem_(problem),
        keeps_certificates_(keeps_certificates),
        followed_(certificate::list_followed_trajectories(space)),
        choices_(list_choices(problem)),
        keeps_mode_(space.assembly_mode && keeps_assembly_mode(space.start.design, space.start.design.minimize)),
        judge_(certificate::make_length_design_judge(space, followed_)),
        bound_(space, *judge_, bound_options()),
        clock_(problem, problem.search.max_time - (keeps_mode_ ? other_mode_seconds(problem) : 0)) {}

  DesignOutcome solve() {
    raise_bound(std::min(max_first_seconds, first_time_fraction * problem_.search.max_time));
    if (const LengthBound first = bound_.result(); is_reached(first)) {
      DesignOutcome outcome = solve_at_lengths(first.design);
      if (reaches(outcome, first)) return outcome;
    }
    DesignOutcome outcome = search();
    const LengthBound last = bound_.result();
    if (last.design.size() == 0 || reaches(outcome, last)) return outcome;
    DesignOutcome lighter = solve_at_lengths(last.design);
    if (!is_design(lighter) || (is_design(outcome) && !is_better(lighter, outcome))) return outcome;
    lighter.effort = outcome.effort;
    lighter.search_summary = outcome.search_summary;
    lighter.optimality = outcome.optimality;
    return lighter;
  }

  LengthBound bound() const { return bound_.result(); }

  /// How many elements suffice, if the requested numbers do not.
  std::optional<LengthBound> find_required_count() {
    certificate::LengthBoundOptions options = bound_options();
    for (certificate::ElementChoice& choice : options.choices) choice.max_count = -1;
    if (options.choices.empty() || clock_.was_interrupted()) return std::nullopt;
    certificate::LengthBoundSearch search(space_, *judge_, options);
    const double end = clock_.elapsed() + max_count_seconds;
    search.run([&] { return clock_.elapsed() > end || search.has_design(); });
    LengthBound found = search.result();
    if (!found.reason.empty() || found.design.size() == 0) return std::nullopt;
    return found;
  }

  /// Names a lighter design in another assembly mode, which the bound covers but the design is not allowed to take;
  /// empty without one.
  std::string find_other_mode(const DesignOutcome& outcome) {
    if (!keeps_mode_ || !is_design(outcome) || !(outcome.gap() > min_mode_gain * outcome.objective)) return "";
    DesignSpace space = space_;
    space.assembly_mode = nullptr;
    space = follow_assembly_mode(std::move(space), false);
    const std::unique_ptr<certificate::LengthDesignJudge> judge =
        certificate::make_length_design_judge(space, followed_);
    certificate::LengthBoundOptions options = bound_options();
    options.gap_tolerance = min_mode_gain;
    options.keeps_certificates = false;
    certificate::LengthBoundSearch search(space, *judge, options);
    const double end = clock_.elapsed() + other_mode_seconds(problem_);
    search.run([&] { return clock_.is_interrupted() || clock_.elapsed() > end; });
    const LengthBound found = search.result();
    if (found.design.size() == 0 || !(found.best < outcome.objective * (1 - min_mode_gain)) ||
        (found.count >= 0 && found.count != certificate::count_min_elements(choices_, outcome.x)) ||
        !space.instantiate(found.design).is_other_mode)
      return "";
    SearchBudget budget(1, {});
    const SolverContext context(problem_, budget);
    std::string lengths;
    for (const int i : geometric_variables(context))
      lengths += fmt::format("{}{} = {:.6g}", lengths.empty() ? "" : ", ",
                             problem_.variables[static_cast<std::size_t>(i)].name, found.design[i]);
    return fmt::format(
        "another assembly mode needs only {:.6g} kg, with {}; 'assembly_mode: any' under 'design' allows it",
        found.best, lengths);
  }

 private:
  certificate::LengthBoundOptions bound_options() const {
    certificate::LengthBoundOptions options;
    options.max_nodes = max_bounded_boxes;
    options.gap_tolerance = closed_gap;
    options.required_trajectories = followed_;
    options.choices = choices_;
    options.keeps_certificates = keeps_certificates_;
    return options;
  }

  static bool is_reached(const LengthBound& bound) {
    return bound.reason.empty() && bound.design.size() > 0 && bound.gap() <= reached_gap &&
           (bound.count < 0 || bound.is_count_proved);
  }

  /// Whether an outcome is as good as the best design of the bound.
  bool reaches(const DesignOutcome& outcome, const LengthBound& bound) const {
    if (!is_design(outcome)) return false;
    const int count = bound.count < 0 ? bound.count : certificate::count_min_elements(choices_, outcome.x);
    return count < bound.count || (count == bound.count && outcome.objective <= bound.best * (1 + reached_gap));
  }

  /// Both are designs: fewer elements come first.
  bool is_better(const DesignOutcome& one, const DesignOutcome& other) const {
    const int count = certificate::count_min_elements(choices_, one.x),
              others = certificate::count_min_elements(choices_, other.x);
    return count < others || (count == others && one.objective < other.objective);
  }

  void raise_bound(double seconds) {
    const double end = clock_.elapsed() + seconds;
    bound_.run([&] { return clock_.is_interrupted() || clock_.elapsed() > end; });
  }

  /// Searches from the best lengths so far, and raises the bound in the time that is left.
  DesignOutcome search() {
    const LengthBound known = bound_.result();
    DesignProblem from_best = problem_;
    if (known.design.size() > 0) set_start(from_best, known.design);
    if (known.reason.empty() && known.count < 0 && std::isfinite(known.lower_bound))
      from_best.proved_lower_bound = known.lower_bound;
    const bool is_decided = !known.reason.empty() || bound_.is_finished();
    from_best.search.max_time = known.is_impossible() ? std::min(clock_.remaining(), max_compromise_seconds)
                                : is_decided          ? clock_.remaining()
                                                      : search_time_fraction * clock_.remaining();
    from_best.search.max_time = std::max(from_best.search.max_time, 1e-3);
    const double before = clock_.elapsed();
    DesignOutcome outcome = solve_design(from_best);
    if (known.design.size() > 0) describe_start(outcome);
    if (is_decided) return outcome;
    if (is_design(outcome) && outcome.status == DesignStatus::balanced) bound_.add_design(outcome.x, outcome.objective);
    if (!clock_.was_interrupted())
      raise_bound(std::min(clock_.remaining(), std::max(min_second_seconds, clock_.elapsed() - before)));
    return outcome;
  }

  /// The best masses at the lengths of x; in a short time even if the search is interrupted.
  DesignOutcome solve_at_lengths(const VectorX& x) {
    DesignProblem whole = problem_;
    whole.search.max_time =
        clock_.is_interrupted() ? min_completion_seconds : std::max(clock_.remaining(), min_completion_seconds);
    if (clock_.is_interrupted()) whole.on_progress = {};
    DesignProblem fixed = whole;
    fixed.is_subproblem = true;
    set_start(fixed, x);
    SearchBudget budget(fixed.search.max_time, fixed.on_progress);
    const SolverContext context(whole, budget);
    for (const int i : geometric_variables(context)) {
      DesignVariable& length = fixed.variables[static_cast<std::size_t>(i)];
      length.lower = length.upper = length.start;
      length.discrete_values.clear();
      for (study::DifferentNumbers& different : fixed.all_different)
        if (std::erase(different.numbers, i) > 0) different.taken.push_back(length.start);
    }
    DesignOutcome outcome = solve_design(fixed);
    complete_design(whole, std::max(clock_.remaining(), min_completion_seconds), outcome);
    describe_start(outcome);
    // what is proved at these lengths says nothing about others
    outcome.lower_bound = std::numeric_limits<double>::quiet_NaN();
    if (outcome.optimality == Optimality::proved_global) outcome.optimality = Optimality::local_optimum;
    if (outcome.selection) outcome.selection->is_min_count_proved = false;
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
      outcome.residuals_before =
          scaled_residuals(conditions, conditions::term_values(start, problem_.options.loose_springs));
  }

  const DesignSpace& space_;
  const DesignProblem& problem_;
  bool keeps_certificates_;
  std::vector<int> followed_;  ///< trajectories that the start values can follow
  std::vector<certificate::ElementChoice> choices_;
  bool keeps_mode_;  ///< that of the start values
  std::unique_ptr<certificate::LengthDesignJudge> judge_;
  certificate::LengthBoundSearch bound_;
  DesignClock clock_;
};

/// Why no lengths meet the conditions.
/// @param required as BoundedSearch::find_required_count
std::string describe_impossibility(const DesignProblem& problem, const LengthBound& bound,
                                   const std::optional<LengthBound>& required) {
  const std::string where = bound.trajectories.empty() ? "" : " with which the trajectories can be followed";
  if (problem.cardinality_constraints.empty())
    return "no masses and places within the bounds of the free numbers meet the conditions, at any lengths" + where;
  int count = 0;
  std::string kinds;
  bool has_limit = true;
  for (const CardinalityConstraint& choice : problem.cardinality_constraints) {
    has_limit = has_limit && choice.max_count >= 0;
    count += choice.max_count;
    kinds += (kinds.empty() ? "" : " and ") + choice.kind;
  }
  if (!has_limit) return fmt::format("no set of {} meets the conditions, at any lengths{}", kinds, where);
  const std::string text = fmt::format("no set of {} {} meets the conditions, at any lengths{}", count, kinds, where);
  if (!required) return text;
  return fmt::format("{}; a set of {} does{}", text, required->count,
                     required->is_count_proved ? ", and none smaller" : "");
}

/// Number of elements that is needed, as far as bound and search show it.
/// @return whether the bound agrees with the outcome
bool apply_count(const LengthBound& bound, int count, ElementSelection& selection) {
  if (count < bound.count) return !bound.is_count_proved;
  if (count > bound.count) return true;
  selection.min_count = count;
  selection.is_min_count_proved = bound.is_count_proved;
  return true;
}

/// @return whether the bound agrees with the outcome
bool apply_bound(const DesignProblem& problem, const LengthBound& bound, const std::optional<LengthBound>& required,
                 DesignOutcome& outcome) {
  const bool has_design = is_design(outcome) && outcome.status == DesignStatus::balanced;
  if (bound.is_impossible()) {
    if (has_design) return false;
    if (outcome.status != DesignStatus::compromise) return true;
    outcome.status = DesignStatus::infeasible;
    outcome.is_proved_infeasible = true;
    outcome.reason = describe_impossibility(problem, bound, required);
    if (required && outcome.selection) {
      outcome.selection->min_count = required->count;
      outcome.selection->is_min_count_proved = required->is_count_proved;
    }
    return true;
  }
  if (!has_design) return true;
  if (bound.count >= 0 && outcome.selection) {
    const int count = certificate::count_min_elements(list_choices(problem), outcome.x);
    if (!apply_count(bound, count, *outcome.selection)) return false;
    if (count != bound.count) return true;
  }
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
    BoundedSearch search(requested, problem, options.keeps_certificates);
    outcome = search.solve();
    found = search.bound();
    std::optional<LengthBound> required;
    if (found.is_impossible()) required = search.find_required_count();
    if (found.reason.empty() && !apply_bound(problem, found, required, outcome))
      found.reason = "a design was found that is lighter than its bound";
    if (std::string note = search.find_other_mode(outcome); !note.empty()) outcome.notes.push_back(std::move(note));
  } else if (!options.is_modular && options.excluded.empty() &&
             minimises_motion_figures(requested.start.design.minimize)) {
    outcome = solve_with_figure_bound(requested, requested.start.design.minimize, problem, found);
  } else {
    outcome = solve_design(problem);
  }
  if (found.reason.empty() || (outcome.method == DesignMethod::geometric && found.reason != no_free_length))
    bound = std::move(found);
  return outcome;
}

std::string find_certificate_obstacle(const DesignSpace& space, const DesignStudyOptions& options) {
  if (space.start.design.cases.size() > 0) return "there are load cases";
  const DesignSpace requested = requested_space(space, options);
  std::string obstacle = find_obstacle(requested, options);
  if (!obstacle.empty()) return obstacle;
  const auto& numbers = requested.start.free_numbers;
  const auto has_sizes = [](const FreeNumber& number) { return !number.discrete_values.empty(); };
  if (!requested.start.design.cardinality.empty() || std::any_of(numbers.begin(), numbers.end(), has_sizes))
    return "it cannot hold sizes and choices yet; the bound itself includes them";
  return certificate::list_length_geometries(requested, certificate::list_followed_trajectories(requested)).reason;
}

}  // namespace balance::design
