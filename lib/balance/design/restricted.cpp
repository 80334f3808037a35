#include "balance/design/restricted.hpp"

#include <algorithm>

namespace balance::designing {

namespace {

/// An inner problem is one of many.
constexpr int inner_restarts = 6, inner_evaluations = 2000;

std::vector<int> numbers_that(const Context& context, bool geometric) {
  std::vector<int> numbers;
  for (int i = 0; i < context.box.size(); ++i)
    if (context.survey.geometric[static_cast<std::size_t>(i)] == geometric) numbers.push_back(i);
  return numbers;
}

/// @param all the numbers that a part of them stands for
void hold_others(Objective& objective, const std::function<VectorX(const VectorX&)>& all) {
  if (!objective.of_variables) return;
  objective.of_variables = [whole = objective.of_variables, all](const VectorX& u) { return whole(all(u)); };
  if (objective.trouble)
    objective.trouble = [whole = objective.trouble, all](const VectorX& u) { return whole(all(u)); };
}

}  // namespace

std::vector<int> inertial_numbers(const Context& context) { return numbers_that(context, false); }
std::vector<int> geometric_numbers(const Context& context) { return numbers_that(context, true); }

DesignProblem at_fixed_geometry(const Context& context, const VectorX& x, double seconds) {
  const DesignProblem& whole = context.problem;
  const std::vector<int> kept = inertial_numbers(context);
  const auto all = [x, kept](const VectorX& part) {
    VectorX numbers = x;
    numbers(kept) = part;
    return numbers;
  };
  DesignProblem part = whole;
  part.variables.clear();
  for (const int i : kept) {
    Variable variable = whole.variables[static_cast<std::size_t>(i)];
    variable.start = std::clamp(x[i], variable.lower, variable.upper);
    part.variables.push_back(std::move(variable));
  }
  part.mechanism_at = [&whole, all](const VectorX& u) { return whole.mechanism_at(all(u)); };
  if (whole.fault) part.fault = [&whole, all](const VectorX& u) { return whole.fault(all(u)); };
  part.options = context.options;
  part.obstacle = {};
  part.objective_at = {};
  part.limits_at = {};
  part.figures_at = part.whole_figures_at = {};
  part.bounded_at = {};
  part.bounded = 0;
  part.least_beyond = {};
  part.inner = true;
  part.watch = [&context](const SearchProgress&) { return !context.budget.interrupted(); };
  part.search.seconds = seconds;
  part.search.restarts = std::min(whole.search.restarts, inner_restarts);
  part.search.evaluations = std::min(whole.search.evaluations, inner_evaluations);
  if (whole.limits_at) {
    part.limits = whole.limits_at(x, kept, context.options.loose_springs);
  } else {
    for (DesignLimit& limit : part.limits) hold_others(limit.figure, all);
  }
  if (!whole.objective) return part;
  if (whole.pieces_at)
    part.pieces_at = [&whole, all, kept](const VectorX& u) {
      auto pieces = whole.pieces_at(all(u));
      if (pieces)
        for (MaximumTerm& term : *pieces) term.slopes = term.slopes(Eigen::all, kept).eval();
      return pieces;
    };
  if (whole.objective_at) {
    part.objective = whole.objective_at(x, kept, context.options.loose_springs);
  } else {
    hold_others(*part.objective, all);
  }
  return part;
}

}  // namespace balance::designing
