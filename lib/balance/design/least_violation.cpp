#include "balance/design/least_violation.hpp"

#include "balance/base/error.hpp"
#include "balance/design/limits.hpp"

#include <algorithm>
#include <limits>
#include <stdexcept>

namespace balance::designing {

namespace {

/// Part of a limit's bound that is left where a search for a design within it may end.
constexpr double enough = 1e-3;

double worst_of(const std::vector<DesignLimit>& limits, const VectorX& parameters, VectorX* gradient) {
  double worst = -enough;
  if (gradient != nullptr) gradient->setZero(parameters.size());
  VectorX slope;
  for (const DesignLimit& limit : limits) {
    const double here =
        violation(limit, limit.figure.of_parameters(parameters, gradient != nullptr ? &slope : nullptr));
    if (here <= worst) continue;
    worst = here;
    if (gradient != nullptr) *gradient = (violation(limit, 1) - violation(limit, 0)) * slope;
  }
  return worst;
}

Objective largest_violation(std::vector<DesignLimit> limits, const DesignProblem& problem) {
  const auto all = [&](const auto& holds) { return std::all_of(limits.begin(), limits.end(), holds); };
  Objective objective;
  objective.name = "largest violation of a limit";
  objective.lower_bound = -enough;
  objective.convex = all([](const DesignLimit& l) { return l.figure.constant || (l.figure.convex && !l.at_least); });
  if (all([](const DesignLimit& l) { return static_cast<bool>(l.figure.of_parameters); })) {
    objective.of_parameters = [limits](const VectorX& parameters, VectorX* gradient) {
      return worst_of(limits, parameters, gradient);
    };
    return objective;
  }
  objective.of_variables = [limits, mechanism = problem.mechanism_at,
                            loose = problem.options.loose_springs](const VectorX& x) {
    double worst = -enough;
    std::optional<VectorX> parameters;
    for (const DesignLimit& limit : limits) {
      if (limit.figure.of_parameters && !parameters) parameters = parameter_values(mechanism(x), loose);
      const double value =
          limit.figure.of_parameters ? limit.figure.of_parameters(*parameters, nullptr) : limit.figure.of_variables(x);
      const double here = violation(limit, value);
      if (!(here <= worst)) worst = here;  // one without a value too
    }
    return worst;
  };
  return objective;
}

}  // namespace

DesignProblem least_violation(const DesignProblem& problem) {
  DesignProblem other = problem;
  other.objective = largest_violation(problem.limits, problem);
  other.figures_at = other.whole_figures_at = {};
  if (problem.bounded == static_cast<int>(problem.limits.size()))
    other.least_beyond = -enough;
  else
    other.bounded_at = {};
  other.bounded = 0;
  other.objective_at = {};
  other.limits.clear();
  other.limits_at = {};
  if (problem.limits_at)
    other.objective_at = [&problem](const VectorX& x, const std::vector<int>& kept, const LooseSprings& loose) {
      DesignProblem part = problem;
      part.options.loose_springs = loose;
      part.mechanism_at = [&problem, x, kept](const VectorX& numbers) {
        VectorX all = x;
        all(kept) = numbers;
        return problem.mechanism_at(all);
      };
      return largest_violation(problem.limits_at(x, kept, loose), part);
    };
  return other;
}

double value_of(const DesignProblem& problem, const Objective& figure, const VectorX& x) {
  try {
    if (figure.of_variables) return figure.of_variables(x);
    return figure.of_parameters(parameter_values(problem.mechanism_at(x), problem.options.loose_springs), nullptr);
  } catch (const SpecError&) {
    return std::numeric_limits<double>::quiet_NaN();  // an expression of the spec has no value here
  } catch (const std::invalid_argument&) {
    return std::numeric_limits<double>::quiet_NaN();  // nor is there a motion
  }
}

}  // namespace balance::designing
