#include "balance/synthesis/design/variable_classification.hpp"

#include "balance/foundation/base/elementary.hpp"
#include "balance/foundation/base/error.hpp"
#include "balance/synthesis/design/solve_design.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>

namespace balance::design {

namespace {

/// Unit coordinates this close to a bound are snapped to it.
constexpr double bound_snap_tolerance = 1e-14;

}  // namespace

VariableScaling::VariableScaling(const std::vector<DesignVariable>& variables) {
  const auto n = static_cast<Eigen::Index>(variables.size());
  for (VectorX* v : {&lower_, &upper_, &start_numbers_, &start_, &centre_, &half_}) v->setZero(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const DesignVariable& v = variables[static_cast<std::size_t>(i)];
    if (!std::isfinite(v.lower) || !std::isfinite(v.upper) || !(v.lower <= v.start && v.start <= v.upper))
      throw std::invalid_argument(v.name + ": a free number needs finite bounds with its start value between them");
    lower_[i] = v.lower;
    upper_[i] = v.upper;
    start_numbers_[i] = v.start;
    centre_[i] = (v.lower + v.upper) / 2;
    half_[i] = (v.upper - v.lower) / 2;
    start_[i] = half_[i] > 0 ? std::clamp((v.start - centre_[i]) / half_[i], -1.0, 1.0) : 0.0;
  }
}

VectorX VariableScaling::to_variables(const VectorX& u) const {
  VectorX x(u.size());
  for (Eigen::Index i = 0; i < u.size(); ++i) {
    if (u[i] == start_[i])
      x[i] = start_numbers_[i];
    else if (u[i] <= -1 + bound_snap_tolerance)
      x[i] = lower_[i];
    else if (u[i] >= 1 - bound_snap_tolerance)
      x[i] = upper_[i];
    else
      x[i] = std::clamp(centre_[i] + half_[i] * u[i], lower_[i], upper_[i]);
    if (std::abs(x[i]) <= 1e-16 * half_[i] && lower_[i] <= 0 && upper_[i] >= 0) x[i] = 0;
  }
  return x;
}

VectorX VariableScaling::to_unit(const VectorX& x) const {
  VectorX u(x.size());
  for (int i = 0; i < static_cast<int>(x.size()); ++i) u[i] = to_unit(i, x[i]);
  return u;
}

double VariableScaling::to_unit(int i, double x) const {
  if (!(half_[i] > 0)) return 0;
  return x == start_numbers_[i] ? start_[i] : std::clamp((x - centre_[i]) / half_[i], -1.0, 1.0);
}

namespace {

/// Marks springs of zero free length whose end points vary.
dynamics::FreeSprings springs_with_free_ends(const Mechanism& base, const std::vector<Mechanism>& others,
                                             dynamics::FreeSprings loose) {
  const std::size_t n = base.springs.size();
  loose.resize(n, false);
  const auto zero_length = [](const Spring& spring) { return spring.free_length == 0; };
  for (std::size_t s = 0; s < n; ++s) {
    const Spring& spring = base.springs[s];
    const bool moves = std::any_of(others.begin(), others.end(), [&](const Mechanism& m) {
      return !is_equal_to_rounding(m.springs[s].point_first, spring.point_first) ||
             !is_equal_to_rounding(m.springs[s].point_second, spring.point_second);
    });
    const bool zero = zero_length(spring) && std::all_of(others.begin(), others.end(),
                                                         [&](const Mechanism& m) { return zero_length(m.springs[s]); });
    if (moves && zero) loose[s] = true;
  }
  if (std::none_of(loose.begin(), loose.end(), [](bool l) { return l; })) loose.clear();
  return loose;
}

}  // namespace

bool VariableClassification::has_geometric() const {
  return std::any_of(is_geometric.begin(), is_geometric.end(), [](bool g) { return g; });
}

bool VariableClassification::has_effect(int variable, int feature) const {
  const double before = base_features[feature], after = perturbed_features[static_cast<std::size_t>(variable)][feature];
  return std::abs(after - before) > change_threshold * std::max(std::abs(before), std::abs(after));
}

namespace {

/// Maximum number of attempts to find another value of a variable or another point.
constexpr int max_sampling_attempts = 60;

/// The mechanism at u; std::nullopt if an expression of the spec has no value.
std::optional<Mechanism> try_build_mechanism(const VariableScaling& scaling, const DesignProblem& problem,
                                             const VectorX& u) {
  try {
    Mechanism mechanism = problem.model->build_mechanism(scaling.to_variables(u));
    if (collect_geometry(mechanism, {}).allFinite() && dynamics::parameter_values(mechanism, {}).allFinite())
      return mechanism;
  } catch (const SpecError&) {
  }
  return std::nullopt;
}

}  // namespace

VariableClassification classify_variables(const VariableScaling& scaling, const DesignProblem& problem) {
  VariableClassification result;
  const int n = scaling.size();
  // Inside the bounds, where masses are positive; far enough from the other values for clear differences.
  numerics::UniformRandom random(problem.search.seed);
  result.base = random.sample_point(n, 0.1, 0.4);
  result.perturbed = random.sample_point(n, -0.8, -0.5);
  std::optional<Mechanism> at_base = try_build_mechanism(scaling, problem, result.base);
  for (int k = 0; !at_base && k < max_sampling_attempts; ++k) {
    result.base =
        k < max_sampling_attempts / 2
            ? random.sample_point(n, -0.95, 0.95)
            : clip_to_unit_box(scaling.start() + random.sample_point(n) / (k + 2 - max_sampling_attempts / 2));
    at_base = try_build_mechanism(scaling, problem, result.base);
  }
  if (!at_base) result.base = scaling.start();
  result.base_mechanism = at_base ? *at_base : problem.model->build_mechanism(scaling.to_variables(result.base));
  std::vector<Mechanism> others;
  for (int i = 0; i < n; ++i) {
    VectorX u = result.base;
    u[i] = result.perturbed[i];
    std::optional<Mechanism> other = try_build_mechanism(scaling, problem, u);
    for (int k = 0; !other && k < max_sampling_attempts; ++k) {
      const int late = std::max(0, k - max_sampling_attempts / 2);
      const double narrow = elementary::pow(0.7, late);
      u[i] = std::clamp(result.base[i] + narrow * random(-1, 1), -1.0, 1.0);
      if (std::abs(u[i] - result.base[i]) > 1e-6) other = try_build_mechanism(scaling, problem, u);
    }
    result.perturbed[i] = u[i];
    others.push_back(other ? *other : result.base_mechanism);
  }
  result.loose_springs = springs_with_free_ends(result.base_mechanism, others, problem.options.loose_springs);
  result.base_features = compute_features(result.base_mechanism, result.loose_springs);
  ConditionOptions options = problem.options;
  options.loose_springs = result.loose_springs;
  const VectorX base_geometry = collect_condition_geometry(result.base_mechanism, options);
  for (const Mechanism& other : others) {
    result.perturbed_features.push_back(compute_features(other, result.loose_springs));
    result.is_geometric.push_back(!is_equal_to_rounding(collect_condition_geometry(other, options), base_geometry));
  }
  return result;
}

dynamics::FreeSprings find_loose_springs(const DesignProblem& problem) {
  const VariableScaling scaling(problem.variables);
  if (problem.model->build_mechanism(scaling.to_variables(scaling.start())).springs.empty()) return {};
  return design::classify_variables(scaling, problem).loose_springs;
}

}  // namespace balance::design
