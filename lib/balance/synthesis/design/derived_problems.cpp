#include "balance/synthesis/design/derived_problems.hpp"

#include "balance/foundation/base/error.hpp"
#include "balance/synthesis/design/problem_functions.hpp"

#include <algorithm>
#include <limits>
#include <stdexcept>

namespace balance::design {

namespace {

/// Margin, relative to a limit's bound, at which the search for a feasible design may stop.
constexpr double phase_one_margin = 1e-3;

/// Inserts values of the free variables into those of all variables.
struct FixedVariables {
  VectorX x;
  std::vector<int> free;

  VectorX all(const VectorX& u) const {
    VectorX numbers = x;
    numbers(free) = u;
    return numbers;
  }
};

/// Maximum violation of several limits, but at least −phase_one_margin.
class ViolationFunction final : public DesignFunction {
 public:
  /// @param parameters computes the parameters of the mechanism at x, for limits that are functions of them
  ViolationFunction(std::vector<DesignLimit> limits, std::function<VectorX(const VectorX& x)> parameters)
      : limits_(std::move(limits)), parameters_(std::move(parameters)) {}

  Domain domain() const override {
    const bool is_parametric = std::all_of(limits_.begin(), limits_.end(),
                                           [](const DesignLimit& limit) { return limit.figure.is_of_parameters(); });
    return is_parametric ? Domain::parameters : Domain::variables;
  }
  double evaluate(const VectorX& at, VectorX* gradient) const override {
    return domain() == Domain::parameters ? evaluate_parameters(at, gradient) : find_worst(at).violation;
  }
  std::optional<VectorX> gradient(const VectorX& x) const override {
    const Worst worst = find_worst(x);
    if (worst.limit == nullptr) return VectorX::Zero(x.size());
    std::optional<VectorX> slope = worst.limit->figure.function->gradient(x);
    if (slope) *slope *= violation_slope(*worst.limit);
    return slope;
  }

 private:
  struct Worst {
    double violation = -phase_one_margin;
    const DesignLimit* limit = nullptr;  ///< nullptr: all limits have the margin
  };

  double evaluate_parameters(const VectorX& parameters, VectorX* gradient) const {
    double worst = -phase_one_margin;
    if (gradient != nullptr) gradient->setZero(parameters.size());
    VectorX slope;
    for (const DesignLimit& limit : limits_) {
      const double violation = relative_violation(
          limit, limit.figure.function->evaluate(parameters, gradient != nullptr ? &slope : nullptr));
      if (violation <= worst) continue;
      worst = violation;
      if (gradient != nullptr) *gradient = violation_slope(limit) * slope;
    }
    return worst;
  }

  Worst find_worst(const VectorX& x) const {
    Worst worst;
    std::optional<VectorX> parameters;
    for (const DesignLimit& limit : limits_) {
      const bool of_parameters = limit.figure.is_of_parameters();
      if (of_parameters && !parameters) parameters = parameters_(x);
      const double violation =
          relative_violation(limit, limit.figure.function->evaluate(of_parameters ? *parameters : x, nullptr));
      if (!(violation <= worst.violation)) worst = {violation, &limit};  // also for undefined values
    }
    return worst;
  }

  std::vector<DesignLimit> limits_;
  std::function<VectorX(const VectorX& x)> parameters_;
};

Objective make_violation_objective(std::vector<DesignLimit> limits,
                                   std::function<VectorX(const VectorX& x)> parameters) {
  Objective objective;
  objective.name = "largest violation of a limit";
  objective.lower_bound = -phase_one_margin;
  objective.is_convex = std::all_of(limits.begin(), limits.end(), [](const DesignLimit& limit) {
    return limit.figure.is_constant || (limit.figure.is_convex && !limit.is_lower);
  });
  objective.function = std::make_shared<const ViolationFunction>(std::move(limits), std::move(parameters));
  return objective;
}

/// The model of a problem whose objective is the violation of its limits.
class PhaseOneModel final : public DesignModelDecorator {
 public:
  using DesignModelDecorator::DesignModelDecorator;

  Capabilities capabilities() const override {
    const Capabilities base_capabilities = model().capabilities();
    return {.has_convex_limits = base_capabilities.has_convex_limits && base_capabilities.are_all_limits_convex,
            .can_fix_geometry = base_capabilities.can_fix_geometry};
  }
  Objective objective_at_geometry(const VectorX& x, const std::vector<int>& free,
                                  const dynamics::FreeSprings& loose) const override {
    const FixedVariables fixed{x, free};
    return make_violation_objective(model().limits_at_geometry(x, free, loose), [this, fixed, loose](const VectorX& u) {
      return dynamics::parameter_values(build_mechanism(fixed.all(u)), loose);
    });
  }
  std::vector<DesignLimit> limits_at_geometry(const VectorX& /*x*/, const std::vector<int>& /*free*/,
                                              const dynamics::FreeSprings& /*loose*/) const override {
    return {};
  }
};

}  // namespace

DesignProblem make_phase_one_problem(const DesignProblem& problem) {
  DesignProblem phase_one = problem;
  phase_one.model = std::make_shared<const PhaseOneModel>(problem.model);
  phase_one.objective = make_violation_objective(
      problem.limits, [model = problem.model, loose = problem.options.loose_springs](const VectorX& x) {
        return dynamics::parameter_values(model->build_mechanism(x), loose);
      });
  phase_one.limits.clear();
  if (phase_one.model->capabilities().has_convex_limits) phase_one.violation_floor = -phase_one_margin;
  return phase_one;
}

VectorX start_values(const DesignProblem& problem) {
  VectorX start(static_cast<Eigen::Index>(problem.variables.size()));
  for (Eigen::Index i = 0; i < start.size(); ++i) start[i] = problem.variables[static_cast<std::size_t>(i)].start;
  return start;
}

void set_start(DesignProblem& problem, const VectorX& x) {
  for (std::size_t i = 0; i < problem.variables.size(); ++i) {
    DesignVariable& variable = problem.variables[i];
    variable.start = std::clamp(x[static_cast<Eigen::Index>(i)], variable.lower, variable.upper);
  }
}

bool is_single_design(const DesignProblem& problem) {
  return std::all_of(problem.variables.begin(), problem.variables.end(),
                     [](const DesignVariable& variable) { return variable.lower == variable.upper; });
}

double evaluate_figure(const DesignProblem& problem, const Objective& figure, const VectorX& x) {
  try {
    return figure.function->evaluate(
        figure.is_of_parameters()
            ? dynamics::parameter_values(problem.model->build_mechanism(x), problem.options.loose_springs)
            : x,
        nullptr);
  } catch (const SpecError&) {
    return std::numeric_limits<double>::quiet_NaN();  // an expression of the spec has no value here
  } catch (const std::invalid_argument&) {
    return std::numeric_limits<double>::quiet_NaN();  // there is no motion
  }
}

namespace {

/// Effort limits of an inner problem, which is one of many.
constexpr int max_inner_restarts = 6, max_inner_evaluations = 2000;

std::vector<int> list_variables(const SolverContext& context, bool geometric) {
  std::vector<int> numbers;
  for (int i = 0; i < context.scaling.size(); ++i)
    if (context.classification.is_geometric[static_cast<std::size_t>(i)] == geometric) numbers.push_back(i);
  return numbers;
}

/// Restricts a function of all variables to some of them.
class RestrictedFunction final : public DesignFunction {
 public:
  RestrictedFunction(std::shared_ptr<const DesignFunction> function, FixedVariables fixed)
      : function_(std::move(function)), fixed_(std::move(fixed)) {}

  Domain domain() const override { return Domain::variables; }
  double evaluate(const VectorX& u, VectorX* /*gradient*/) const override {
    return function_->evaluate(fixed_.all(u), nullptr);
  }
  bool has_max_terms() const override { return function_->has_max_terms(); }
  std::optional<std::vector<MaxTerm>> max_terms(const VectorX& u) const override {
    auto terms = function_->max_terms(fixed_.all(u));
    if (terms)
      for (MaxTerm& term : *terms) term.jacobian = term.jacobian(Eigen::all, fixed_.free).eval();
    return terms;
  }
  std::optional<VectorX> gradient(const VectorX& u) const override {
    auto slope = function_->gradient(fixed_.all(u));
    if (slope) *slope = (*slope)(fixed_.free).eval();
    return slope;
  }
  std::string failure_reason(const VectorX& u) const override { return function_->failure_reason(fixed_.all(u)); }

 private:
  std::shared_ptr<const DesignFunction> function_;
  FixedVariables fixed_;
};

void fix_other_variables(Objective& objective, const FixedVariables& fixed) {
  if (objective.is_of_parameters()) return;
  objective.function = std::make_shared<const RestrictedFunction>(objective.function, fixed);
}

/// Fixes lengths and ratios; the feasibility of the motion has been checked already.
class FixedGeometryModel final : public DesignModelDecorator {
 public:
  FixedGeometryModel(std::shared_ptr<const DesignModel> base_model, FixedVariables fixed)
      : DesignModelDecorator(std::move(base_model)), fixed_(std::move(fixed)) {}

  Capabilities capabilities() const override { return {}; }
  Mechanism build_mechanism(const VectorX& u) const override { return model().build_mechanism(fixed_.all(u)); }
  std::string invalidity_reason(const VectorX& u) const override { return model().invalidity_reason(fixed_.all(u)); }
  std::string infeasibility_reason(const VectorX& /*u*/) const override { return ""; }

 private:
  FixedVariables fixed_;
};

}  // namespace

std::vector<int> inertial_variables(const SolverContext& context) { return list_variables(context, false); }
std::vector<int> geometric_variables(const SolverContext& context) { return list_variables(context, true); }

DesignProblem make_fixed_geometry_problem(const SolverContext& context, const VectorX& x, double seconds) {
  const DesignProblem& problem = context.problem;
  const std::vector<int> inertial = inertial_variables(context);
  const FixedVariables fixed{x, inertial};
  DesignProblem restricted = problem;
  restricted.variables.clear();
  for (const int i : inertial) {
    DesignVariable variable = problem.variables[static_cast<std::size_t>(i)];
    variable.start = std::clamp(x[i], variable.lower, variable.upper);
    restricted.variables.push_back(std::move(variable));
  }
  restricted.model = std::make_shared<const FixedGeometryModel>(problem.model, fixed);
  restricted.options = context.options;
  restricted.all_different.clear();  // their indices refer to all variables; the search over sizes obeys them
  restricted.violation_floor = {};
  restricted.is_subproblem = true;
  restricted.on_progress = [&context](const SearchProgress&) { return !context.budget.is_interrupted(); };
  restricted.search.max_time = seconds;
  restricted.search.max_restarts = std::min(problem.search.max_restarts, max_inner_restarts);
  restricted.search.max_evaluations = std::min(problem.search.max_evaluations, max_inner_evaluations);
  if (problem.model->capabilities().can_fix_geometry) {
    restricted.limits = problem.model->limits_at_geometry(x, inertial, context.options.loose_springs);
    if (problem.objective)
      restricted.objective = problem.model->objective_at_geometry(x, inertial, context.options.loose_springs);
  } else {
    for (DesignLimit& limit : restricted.limits) fix_other_variables(limit.figure, fixed);
    if (restricted.objective) fix_other_variables(*restricted.objective, fixed);
  }
  return restricted;
}

}  // namespace balance::design
