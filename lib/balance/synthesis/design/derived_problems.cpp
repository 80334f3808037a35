#include "balance/synthesis/design/derived_problems.hpp"

#include "balance/foundation/base/error.hpp"
#include "balance/synthesis/design/problem_functions.hpp"

#include <algorithm>
#include <limits>
#include <stdexcept>

namespace balance::design {

namespace {

/// Part of a limit's bound that is left where a search for a design within it may end.
constexpr double phase_one_margin = 1e-3;

double max_violation(const std::vector<DesignLimit>& limits, const VectorX& parameters, VectorX* gradient) {
  double worst = -phase_one_margin;
  if (gradient != nullptr) gradient->setZero(parameters.size());
  VectorX slope;
  for (const DesignLimit& limit : limits) {
    const double here =
        relative_violation(limit, limit.figure.of_parameters(parameters, gradient != nullptr ? &slope : nullptr));
    if (here <= worst) continue;
    worst = here;
    if (gradient != nullptr) *gradient = (relative_violation(limit, 1) - relative_violation(limit, 0)) * slope;
  }
  return worst;
}

Objective make_violation_objective(std::vector<DesignLimit> limits, const DesignProblem& problem) {
  const auto all = [&](const auto& holds) { return std::all_of(limits.begin(), limits.end(), holds); };
  Objective objective;
  objective.name = "largest violation of a limit";
  objective.lower_bound = -phase_one_margin;
  objective.is_convex =
      all([](const DesignLimit& l) { return l.figure.is_constant || (l.figure.is_convex && !l.is_lower); });
  if (all([](const DesignLimit& l) { return static_cast<bool>(l.figure.of_parameters); })) {
    objective.of_parameters = [limits](const VectorX& parameters, VectorX* gradient) {
      return max_violation(limits, parameters, gradient);
    };
    return objective;
  }
  objective.of_variables = [limits, mechanism = problem.build_mechanism,
                            loose = problem.options.loose_springs](const VectorX& x) {
    double worst = -phase_one_margin;
    std::optional<VectorX> parameters;
    for (const DesignLimit& limit : limits) {
      if (limit.figure.of_parameters && !parameters) parameters = parameter_values(mechanism(x), loose);
      const double value =
          limit.figure.of_parameters ? limit.figure.of_parameters(*parameters, nullptr) : limit.figure.of_variables(x);
      const double here = relative_violation(limit, value);
      if (!(here <= worst)) worst = here;  // one without a value too
    }
    return worst;
  };
  return objective;
}

}  // namespace

DesignProblem make_phase_one_problem(const DesignProblem& problem) {
  DesignProblem other = problem;
  other.objective = make_violation_objective(problem.limits, problem);
  other.convex_terms_at = other.all_convex_terms_at = {};
  if (problem.convex_limit_count == static_cast<int>(problem.limits.size()))
    other.violation_floor = -phase_one_margin;
  else
    other.convex_limits = {};
  other.convex_limit_count = 0;
  other.objective_at_geometry = {};
  other.limits.clear();
  other.limits_at_geometry = {};
  if (problem.limits_at_geometry)
    other.objective_at_geometry = [&problem](const VectorX& x, const std::vector<int>& kept, const FreeSprings& loose) {
      DesignProblem part = problem;
      part.options.loose_springs = loose;
      part.build_mechanism = [&problem, x, kept](const VectorX& numbers) {
        VectorX all = x;
        all(kept) = numbers;
        return problem.build_mechanism(all);
      };
      return make_violation_objective(problem.limits_at_geometry(x, kept, loose), part);
    };
  return other;
}

double evaluate_figure(const DesignProblem& problem, const Objective& figure, const VectorX& x) {
  try {
    if (figure.of_variables) return figure.of_variables(x);
    return figure.of_parameters(parameter_values(problem.build_mechanism(x), problem.options.loose_springs), nullptr);
  } catch (const SpecError&) {
    return std::numeric_limits<double>::quiet_NaN();  // an expression of the spec has no value here
  } catch (const std::invalid_argument&) {
    return std::numeric_limits<double>::quiet_NaN();  // nor is there a motion
  }
}

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
