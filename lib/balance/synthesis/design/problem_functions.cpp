#include "balance/synthesis/design/problem_functions.hpp"

#include "balance/foundation/base/cpu_time.hpp"
#include "balance/foundation/base/error.hpp"
#include "balance/foundation/numerics/extrema.hpp"
#include "balance/synthesis/design/solve_design.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace balance::design {

namespace {

/// Violation up to which a search takes a limit as satisfied: less than limit_tolerance, as numbers are rounded when
/// they leave the search.
constexpr double search_limit_tolerance = limit_tolerance / 2;

/// Indices of the requested parameters among those that include the products of all loose springs.
std::vector<int> find_parameter_indices(const Mechanism& mechanism, const dynamics::FreeSprings& requested_springs,
                                        const dynamics::FreeSprings& all_springs) {
  const auto requested_parameters = dynamics::list_parameters(mechanism, requested_springs),
             all_parameters = dynamics::list_parameters(mechanism, all_springs);
  std::vector<int> result;
  for (const dynamics::Parameter& w : requested_parameters)
    for (std::size_t p = 0; p < all_parameters.size(); ++p)
      if (all_parameters[p].owner_kind == w.owner_kind && all_parameters[p].index == w.index &&
          all_parameters[p].slot == w.slot)
        result.push_back(static_cast<int>(p));
  return result;
}

/// The value of a simulation, or `fallback` where an expression of the spec has no value, there is no motion, or the time is over.
template <class Value, class Simulation>
Value evaluate_or(Value fallback, const Simulation& simulation) {
  try {
    return simulation();
  } catch (const SpecError&) {
    return fallback;
  } catch (const std::invalid_argument&) {
    return fallback;
  } catch (const DeadlineExceeded&) {
    return fallback;
  }
}

}  // namespace

ScaledObjective::ScaledObjective(const SolverContext& context, const Objective& objective)
    : context_(context), objective_(objective) {
  if (!objective_.function) throw std::invalid_argument("an objective needs a function");
  parameters_ = find_parameter_indices(context.classification.base_mechanism, context.problem.options.loose_springs,
                                       context.classification.loose_springs);
  const bool is_curved_one_way = objective_.is_convex || objective_.is_concave;
  const bool is_affine = objective_.is_of_parameters() && is_curved_one_way && is_affine_in_variables();
  convex_ = objective_.is_convex && is_affine;
  concave_ = objective_.is_concave && is_affine;
}

double ScaledObjective::evaluate_by_simulation(const VectorX& u) const {
  return evaluate_or(std::numeric_limits<double>::quiet_NaN(),
                     [&] { return objective_.function->evaluate(context_.scaling.to_variables(u), nullptr); });
}

std::optional<std::vector<MaxTerm>> ScaledObjective::max_terms(const VectorX& u) const {
  using Terms = std::optional<std::vector<MaxTerm>>;
  if (context_.budget.is_past_deadline()) return std::nullopt;
  return evaluate_or(Terms(), [&]() -> Terms {
    Terms terms = objective_.function->max_terms(context_.scaling.to_variables(u));
    if (!terms) return std::nullopt;
    for (MaxTerm& term : *terms) {
      if (!term.values.allFinite() || !term.jacobian.allFinite()) return std::nullopt;
      term.jacobian = term.jacobian * context_.scaling.half_width().asDiagonal();
    }
    return terms;
  });
}

std::optional<VectorX> ScaledObjective::known_gradient(const VectorX& u) const {
  if (has_max_terms()) return max_term_gradient(max_terms(u), u.size());
  return evaluate_or(std::optional<VectorX>(), [&] {
    auto slope = objective_.function->gradient(context_.scaling.to_variables(u));
    if (slope) slope->array() *= context_.scaling.half_width().array();
    return slope && slope->allFinite() ? slope : std::nullopt;
  });
}

/// Uses differences unless the derivatives are known.
VectorX ScaledObjective::gradient_by_simulation(const VectorX& u) const {
  if (const auto slope = known_gradient(u)) return *slope;
  const auto value = [this](const VectorX& v) { return VectorX::Constant(1, evaluate_by_simulation(v)).eval(); };
  return central_difference_jacobian(value, u, 1).transpose();
}

double ScaledObjective::operator()(const VectorX& u, VectorX* gradient) const {
  if (is_simulated()) {
    if (context_.budget.is_past_deadline()) {
      if (gradient != nullptr) gradient->setZero(u.size());
      return std::numeric_limits<double>::quiet_NaN();
    }
    if (gradient != nullptr) *gradient = gradient_by_simulation(u);
    return evaluate_by_simulation(u);
  }
  VectorX features, slope;
  MatrixX slopes;
  context_.features.evaluate(u, features, gradient != nullptr ? &slopes : nullptr);
  if (!features.allFinite()) {
    if (gradient != nullptr) gradient->setZero(u.size());
    return std::numeric_limits<double>::quiet_NaN();
  }
  const double value = objective_.function->evaluate(features(parameters_), gradient != nullptr ? &slope : nullptr);
  if (gradient != nullptr) *gradient = slopes(parameters_, Eigen::all).transpose() * slope;
  return value;
}

std::string ScaledObjective::failure_reason(const VectorX& u) const {
  try {
    const VectorX x = context_.scaling.to_variables(u);
    if (std::string reason = objective_.function->failure_reason(x); !reason.empty() || !is_simulated()) return reason;
    objective_.function->evaluate(x, nullptr);
  } catch (const SpecError& error) {
    return error.what();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

double ScaledObjective::round_off() const {
  const Eigen::Index n = context_.scaling.size();
  std::vector<VectorX> points{context_.scaling.start()};
  if (!is_simulated()) points.insert(points.end(), {VectorX::Zero(n), VectorX::Ones(n), -VectorX::Ones(n)});
  double largest = 0;
  for (const VectorX& u : points)
    if (const double value = std::abs((*this)(u, nullptr)); value > largest && std::isfinite(value)) largest = value;
  return relative_figure_round_off * largest;
}

bool ScaledObjective::is_affine_in_variables() const {
  const auto& polynomial = context_.features.polynomial();
  if (!polynomial) return false;
  numerics::UniformRandom random(1);
  for (int sample = 0; sample < 3; ++sample) {
    VectorX features, slope;
    context_.features.evaluate(random.sample_point(context_.scaling.size()), features, nullptr);
    if (!features.allFinite()) return false;
    objective_.function->evaluate(features(parameters_), &slope);
    for (std::size_t p = 0; p < parameters_.size(); ++p)
      if (slope[static_cast<Eigen::Index>(p)] != 0 && !polynomial->is_affine(parameters_[p])) return false;
  }
  return true;
}

double violation_slope(const DesignLimit& limit) {
  const double size = limit.bound != 0 ? std::abs(limit.bound) : 1;
  return limit.is_lower ? -1 / size : 1 / size;
}

double relative_violation(const DesignLimit& limit, double value) {
  return violation_slope(limit) * (value - limit.bound);
}

DesignLimits::DesignLimits(const SolverContext& context) : limits_(context.problem.limits) {
  for (const DesignLimit& limit : limits_) figures_.emplace_back(context, limit.figure);
}

bool DesignLimits::is_convex() const {
  for (std::size_t k = 0; k < limits_.size(); ++k)
    if (!limits_[k].figure.is_constant && !(limits_[k].is_lower ? figures_[k].is_concave() : figures_[k].is_convex()))
      return false;
  return true;
}

void DesignLimits::evaluate(const VectorX& u, VectorX& g, MatrixX* jacobian) const {
  g.resize(size());
  if (jacobian != nullptr) jacobian->resize(size(), u.size());
  VectorX slope;
  for (Eigen::Index k = 0; k < g.size(); ++k) {
    const auto i = static_cast<std::size_t>(k);
    g[k] = -relative_violation(limits_[i], figures_[i](u, jacobian != nullptr ? &slope : nullptr));
    if (jacobian != nullptr) jacobian->row(k) = -violation_slope(limits_[i]) * slope.transpose();
  }
}

bool DesignLimits::is_satisfied(const VectorX& u) const {
  for (int k = 0; k < size(); ++k)
    if (!is_satisfied(u, k)) return false;
  return true;
}

bool DesignLimits::is_satisfied(const VectorX& u, int limit) const {
  return relative_violation(limits_[static_cast<std::size_t>(limit)], value(u, limit)) <= search_limit_tolerance;
}

}  // namespace balance::design
