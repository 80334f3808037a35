#pragma once
/// Least squares within bounds, for lower bounds.

#include "balance/foundation/base/types.hpp"

#include <algorithm>
#include <cmath>

namespace balance::design {

/// min δᵀQδ/2 + cᵀδ within |δ| ≤ w: a few sweeps of coordinate descent from δ.
inline void minimise_in_box(const MatrixX& Q, const VectorX& c, const VectorX& w, VectorX& delta) {
  constexpr int max_sweeps = 60;
  const Eigen::Index n = c.size();
  VectorX gradient = Q * delta + c;
  for (int sweep = 0; sweep < max_sweeps; ++sweep) {
    double change = 0;
    for (Eigen::Index j = 0; j < n; ++j) {
      if (w[j] == 0) continue;
      const double old = delta[j];
      const double next = Q(j, j) > 0 ? std::clamp(old - gradient[j] / Q(j, j), -w[j], w[j])
                                      : (gradient[j] > 0   ? -w[j]
                                         : gradient[j] < 0 ? w[j]
                                                           : old);
      if (next == old) continue;
      delta[j] = next;
      gradient += Q.col(j) * (next - old);
      change = std::max(change, std::abs(next - old) / w[j]);
    }
    if (change < 1e-7) return;
  }
}

/// A lower bound of the convex function f(δ) = value + gradientᵀ(δ' − δ) + … over the box.
inline double box_lower_bound(double value, const VectorX& gradient, const VectorX& delta, const VectorX& w) {
  double bound = value;
  for (Eigen::Index j = 0; j < w.size(); ++j)
    bound += std::min(gradient[j] * (w[j] - delta[j]), gradient[j] * (-w[j] - delta[j]));
  return bound;
}

}  // namespace balance::design
