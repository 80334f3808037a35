#include "balance/synthesis/design/length_bound_search.hpp"

#include "balance/foundation/base/cpu_time.hpp"
#include "balance/synthesis/design/derived_problems.hpp"
#include "balance/synthesis/design/solution_analysis.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace balance::design {

namespace {

/// Part of the time of a design for the bound over all lengths, before the search.
constexpr double max_time_fraction = 0.2, max_bound_seconds = 3;
constexpr long max_bounded_boxes = 2000;
/// Relative: the search takes a design that is as near to the bound as proved.
constexpr double closed_gap = 1e-8;

/// The spec's request with what the options replace.
std::optional<DesignSpace> requested_space(const DesignSpace& space, const DesignStudyOptions& options) {
  const bool has_sizes = std::any_of(space.start.free_numbers.begin(), space.start.free_numbers.end(),
                                     [](const FreeNumber& number) { return !number.discrete_values.empty(); });
  if (options.is_modular || !options.excluded.empty() || has_sizes) return std::nullopt;
  DesignSpace requested = space;
  if (!options.goals.empty()) requested.start.design.goals = options.goals;
  if (!options.minimize.empty()) {
    requested.start.design.minimize = options.minimize;
    requested.start.design.front = {};
  }
  return requested;
}

std::optional<LengthBound> find_bound(const DesignSpace& space, const DesignStudyOptions& options) {
  const std::optional<DesignSpace> requested = requested_space(space, options);
  if (!requested) return std::nullopt;
  const certificate::LinkageReading reading = certificate::read_linkage(*requested);
  if (!reading.linkage || !certificate::has_free_lengths(*reading.linkage)) return std::nullopt;
  const double start_time = thread_cpu_time();
  const double seconds = std::min(max_bound_seconds, max_time_fraction * options.search.max_time);
  LengthBoundOptions bound_options;
  bound_options.max_nodes = max_bounded_boxes;
  bound_options.gap_tolerance = closed_gap;
  bound_options.interrupted = [&] {
    const double elapsed = thread_cpu_time() - start_time;
    return elapsed > seconds || (options.on_progress && !options.on_progress({elapsed, options.search.max_time}));
  };
  bound_options.required_trajectories = list_followed_trajectories(*requested);
  LengthBound bound = bound_over_lengths(*requested, *make_length_design_judge(*requested), bound_options);
  return bound.reason.empty() ? std::optional(std::move(bound)) : std::nullopt;
}

/// Replaces what refers to the start values.
void describe_start(const DesignProblem& problem, DesignOutcome& outcome) {
  if (problem.objective) outcome.start_objective = evaluate_figure(problem, *problem.objective, start_values(problem));
  const Mechanism start = problem.model->build_mechanism(start_values(problem));
  const Conditions conditions = problem.model->derive_conditions(start, problem.goals, problem.options);
  outcome.residuals_before = VectorX();
  if (conditions.status == ConditionsStatus::done && conditions.pivots == outcome.conditions.pivots)
    outcome.residuals_before = scaled_residuals(conditions, term_values(start, problem.options.loose_springs));
}

}  // namespace

DesignOutcome solve_with_length_bound(const DesignSpace& space, const DesignStudyOptions& options,
                                      const DesignProblem& problem, std::optional<LengthBound>& bound) {
  bound = find_bound(space, options);
  if (!bound) return solve_design(problem);
  const bool covers_all = bound->uncovered.empty();
  DesignProblem from_best = problem;
  if (bound->design.size() > 0) set_start(from_best, bound->design);
  if (covers_all && std::isfinite(bound->lower_bound)) from_best.proved_lower_bound = bound->lower_bound;
  DesignOutcome outcome = solve_design(from_best);
  if (bound->design.size() > 0) describe_start(problem, outcome);
  if (!covers_all) return outcome;
  if (bound->is_impossible() && outcome.status == DesignStatus::compromise) {
    outcome.status = DesignStatus::infeasible;
    outcome.is_proved_infeasible = true;
    outcome.reason = "no lengths, masses and places within the bounds of the free numbers meet the conditions";
  } else if (std::isfinite(bound->lower_bound) && outcome.status == DesignStatus::balanced && outcome.within_limits) {
    raise_lower_bound(outcome, bound->lower_bound);
  }
  return outcome;
}

}  // namespace balance::design
