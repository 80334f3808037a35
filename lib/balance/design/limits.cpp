#include "balance/design/limits.hpp"

#include "balance/design/solve.hpp"

#include <algorithm>
#include <cmath>

namespace balance::designing {

namespace {

/// d violation / d value
double by_value(const DesignLimit& limit) {
  const double size = limit.bound != 0 ? std::abs(limit.bound) : 1;
  return limit.at_least ? -1 / size : 1 / size;
}

}  // namespace

double violation(const DesignLimit& limit, double value) { return by_value(limit) * (value - limit.bound); }

Limits::Limits(const Context& context) : limits_(context.problem.limits) {
  for (const DesignLimit& limit : limits_) merits_.emplace_back(context, limit.figure);
}

bool Limits::convex() const {
  for (std::size_t k = 0; k < limits_.size(); ++k)
    if (!limits_[k].figure.constant && (limits_[k].at_least || !merits_[k].convex())) return false;
  return true;
}

void Limits::evaluate(const VectorX& u, VectorX& g, MatrixX* jacobian) const {
  g.resize(size());
  if (jacobian != nullptr) jacobian->resize(size(), u.size());
  VectorX slope;
  for (Eigen::Index k = 0; k < g.size(); ++k) {
    const auto i = static_cast<std::size_t>(k);
    g[k] = -violation(limits_[i], merits_[i](u, jacobian != nullptr ? &slope : nullptr));
    if (jacobian != nullptr) jacobian->row(k) = -by_value(limits_[i]) * slope.transpose();
  }
}

bool Limits::hold(const VectorX& u) const {
  for (std::size_t k = 0; k < limits_.size(); ++k)
    if (!(violation(limits_[k], merits_[k](u, nullptr)) <= kept)) return false;
  return true;
}

}  // namespace balance::designing
