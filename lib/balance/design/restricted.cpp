#include "balance/design/restricted.hpp"

#include <algorithm>

namespace balance::design {

namespace {

/// An inner problem is one of many.
constexpr int max_inner_restarts = 6, max_inner_evaluations = 2000;

std::vector<int> list_variables(const SolverContext& context, bool geometric) {
  std::vector<int> numbers;
  for (int i = 0; i < context.scaling.size(); ++i)
    if (context.classification.is_geometric[static_cast<std::size_t>(i)] == geometric) numbers.push_back(i);
  return numbers;
}

/// @param all the numbers that a part of them stands for
void fix_other_variables(Objective& objective, const std::function<VectorX(const VectorX&)>& all) {
  if (!objective.of_variables) return;
  objective.of_variables = [whole = objective.of_variables, all](const VectorX& u) { return whole(all(u)); };
  if (objective.failure_reason)
    objective.failure_reason = [whole = objective.failure_reason, all](const VectorX& u) { return whole(all(u)); };
}

}  // namespace

std::vector<int> inertial_variables(const SolverContext& context) { return list_variables(context, false); }
std::vector<int> geometric_variables(const SolverContext& context) { return list_variables(context, true); }

DesignProblem make_fixed_geometry_problem(const SolverContext& context, const VectorX& x, double seconds) {
  const DesignProblem& whole = context.problem;
  const std::vector<int> kept = inertial_variables(context);
  const auto all = [x, kept](const VectorX& part) {
    VectorX numbers = x;
    numbers(kept) = part;
    return numbers;
  };
  DesignProblem part = whole;
  part.variables.clear();
  for (const int i : kept) {
    DesignVariable variable = whole.variables[static_cast<std::size_t>(i)];
    variable.start = std::clamp(x[i], variable.lower, variable.upper);
    part.variables.push_back(std::move(variable));
  }
  part.build_mechanism = [&whole, all](const VectorX& u) { return whole.build_mechanism(all(u)); };
  if (whole.invalidity_reason)
    part.invalidity_reason = [&whole, all](const VectorX& u) { return whole.invalidity_reason(all(u)); };
  part.options = context.options;
  part.infeasibility_reason = {};
  part.objective_at_geometry = {};
  part.limits_at_geometry = {};
  part.convex_terms_at = part.all_convex_terms_at = {};
  part.convex_limits = {};
  part.convex_limit_count = 0;
  part.violation_floor = {};
  part.is_subproblem = true;
  part.on_progress = [&context](const SearchProgress&) { return !context.budget.is_interrupted(); };
  part.search.max_time = seconds;
  part.search.max_restarts = std::min(whole.search.max_restarts, max_inner_restarts);
  part.search.max_evaluations = std::min(whole.search.max_evaluations, max_inner_evaluations);
  if (whole.limits_at_geometry) {
    part.limits = whole.limits_at_geometry(x, kept, context.options.loose_springs);
  } else {
    for (DesignLimit& limit : part.limits) fix_other_variables(limit.figure, all);
  }
  if (!whole.objective) return part;
  if (whole.max_terms)
    part.max_terms = [&whole, all, kept](const VectorX& u) {
      auto pieces = whole.max_terms(all(u));
      if (pieces)
        for (MaxTerm& term : *pieces) term.jacobian = term.jacobian(Eigen::all, kept).eval();
      return pieces;
    };
  if (whole.objective_at_geometry) {
    part.objective = whole.objective_at_geometry(x, kept, context.options.loose_springs);
  } else {
    fix_other_variables(*part.objective, all);
  }
  return part;
}

}  // namespace balance::design
