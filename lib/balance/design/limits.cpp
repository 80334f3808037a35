#include "balance/design/limits.hpp"

#include "balance/design/solve.hpp"

#include <algorithm>
#include <cmath>

namespace balance::design {

namespace {

/// d violation / d value
double violation_slope(const DesignLimit& limit) {
  const double size = limit.bound != 0 ? std::abs(limit.bound) : 1;
  return limit.is_lower ? -1 / size : 1 / size;
}

}  // namespace

double relative_violation(const DesignLimit& limit, double value) {
  return violation_slope(limit) * (value - limit.bound);
}

DesignLimits::DesignLimits(const SolverContext& context) : limits_(context.problem.limits) {
  for (const DesignLimit& limit : limits_) merits_.emplace_back(context, limit.figure);
}

bool DesignLimits::is_convex() const {
  for (std::size_t k = 0; k < limits_.size(); ++k)
    if (!limits_[k].figure.is_constant && (limits_[k].is_lower || !merits_[k].is_convex())) return false;
  return true;
}

void DesignLimits::evaluate(const VectorX& u, VectorX& g, MatrixX* jacobian) const {
  g.resize(size());
  if (jacobian != nullptr) jacobian->resize(size(), u.size());
  VectorX slope;
  for (Eigen::Index k = 0; k < g.size(); ++k) {
    const auto i = static_cast<std::size_t>(k);
    g[k] = -relative_violation(limits_[i], merits_[i](u, jacobian != nullptr ? &slope : nullptr));
    if (jacobian != nullptr) jacobian->row(k) = -violation_slope(limits_[i]) * slope.transpose();
  }
}

bool DesignLimits::is_satisfied(const VectorX& u) const {
  for (std::size_t k = 0; k < limits_.size(); ++k)
    if (!(relative_violation(limits_[k], merits_[k](u, nullptr)) <= limit_tolerance)) return false;
  return true;
}

}  // namespace balance::design
