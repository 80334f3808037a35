#include "balance/design/least_violation.hpp"

#include "balance/base/error.hpp"
#include "balance/design/limits.hpp"

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

}  // namespace balance::design
