#include "balance/design/survey.hpp"

#include "balance/base/elementary.hpp"
#include "balance/base/error.hpp"
#include "balance/design/solve.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace balance::designing {

namespace {

/// Springs of zero free length whose ends are free.
LooseSprings springs_with_free_ends(const Mechanism& base, const std::vector<Mechanism>& others, LooseSprings loose) {
  const std::size_t n = base.springs.size();
  loose.resize(n, false);
  const auto zero_length = [](const Spring& spring) { return spring.free_length == 0; };
  for (std::size_t s = 0; s < n; ++s) {
    const Spring& spring = base.springs[s];
    const bool moves = std::any_of(others.begin(), others.end(), [&](const Mechanism& m) {
      return !same_numbers(m.springs[s].point_first, spring.point_first) ||
             !same_numbers(m.springs[s].point_second, spring.point_second);
    });
    const bool zero = zero_length(spring) && std::all_of(others.begin(), others.end(),
                                                         [&](const Mechanism& m) { return zero_length(m.springs[s]); });
    if (moves && zero) loose[s] = true;
  }
  if (std::none_of(loose.begin(), loose.end(), [](bool l) { return l; })) loose.clear();
  return loose;
}

}  // namespace

bool Survey::any_geometric() const {
  return std::any_of(geometric.begin(), geometric.end(), [](bool g) { return g; });
}

bool Survey::touches(int variable, int feature) const {
  const double before = base_features[feature], after = features[static_cast<std::size_t>(variable)][feature];
  return std::abs(after - before) > disturbed * std::max(std::abs(before), std::abs(after));
}

namespace {

/// Tries to find another value of a number, or another point, before they are given up.
constexpr int most_tries = 60;

/// The mechanism at u, or nothing where an expression of the spec has no value.
std::optional<Mechanism> mechanism_or_none(const Box& box, const DesignProblem& problem, const VectorX& u) {
  try {
    Mechanism mechanism = problem.mechanism_at(box.numbers(u));
    if (geometry(mechanism, {}).allFinite() && parameter_values(mechanism, {}).allFinite()) return mechanism;
  } catch (const SpecError&) {
  }
  return std::nullopt;
}

}  // namespace

Survey survey(const Box& box, const DesignProblem& problem) {
  Survey result;
  const int n = box.size();
  // inside the bounds, where masses are positive; not too near the other values, so that differences are clear
  RandomNumbers random(problem.search.seed);
  result.base = random.point(n, 0.1, 0.4);
  result.moved = random.point(n, -0.8, -0.5);
  std::optional<Mechanism> at_base = mechanism_or_none(box, problem, result.base);
  for (int k = 0; !at_base && k < most_tries; ++k) {
    result.base = k < most_tries / 2 ? random.point(n, -0.95, 0.95)
                                     : clipped(box.start() + random.point(n) / (k + 2 - most_tries / 2));
    at_base = mechanism_or_none(box, problem, result.base);
  }
  if (!at_base) result.base = box.start();
  result.at_base = at_base ? *at_base : problem.mechanism_at(box.numbers(result.base));
  std::vector<Mechanism> others;
  for (int i = 0; i < n; ++i) {
    VectorX u = result.base;
    u[i] = result.moved[i];
    std::optional<Mechanism> other = mechanism_or_none(box, problem, u);
    for (int k = 0; !other && k < most_tries; ++k) {
      const int late = std::max(0, k - most_tries / 2);
      const double narrow = elementary::pow(0.7, late);
      u[i] = std::clamp(result.base[i] + narrow * random(-1, 1), -1.0, 1.0);
      if (std::abs(u[i] - result.base[i]) > 1e-6) other = mechanism_or_none(box, problem, u);
    }
    result.moved[i] = u[i];
    others.push_back(other ? *other : result.at_base);
  }
  result.loose = springs_with_free_ends(result.at_base, others, problem.options.loose_springs);
  result.base_features = designing::features(result.at_base, result.loose);
  const VectorX base_geometry = geometry(result.at_base, result.loose);
  for (const Mechanism& other : others) {
    result.features.push_back(designing::features(other, result.loose));
    result.geometric.push_back(!same_numbers(geometry(other, result.loose), base_geometry));
  }
  return result;
}

}  // namespace balance::designing

namespace balance {

LooseSprings find_loose_springs(const DesignProblem& problem) {
  const designing::Box box(problem.variables);
  if (problem.mechanism_at(box.numbers(box.start())).springs.empty()) return {};
  return designing::survey(box, problem).loose;
}

}  // namespace balance
