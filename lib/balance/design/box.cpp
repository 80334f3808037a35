#include "balance/design/box.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace balance::design {

namespace {

/// Unit coordinates so near to a bound are meant to be at it.
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

}  // namespace balance::design
