#include "balance/motion/scout.hpp"

#include <algorithm>
#include <cmath>

namespace balance {

namespace {

/// y between two moments; the basis of degree 5.
void interpolate_hermite(const CoordinateSample& a, const CoordinateSample& b, double time, VectorX& y) {
  const double h = b.time - a.time, s = h > 0 ? (time - a.time) / h : 0;
  const double s3 = s * s * s, s4 = s3 * s, s5 = s4 * s;
  const double rise = 10 * s3 - 15 * s4 + 6 * s5;
  const double leave = s - 6 * s3 + 8 * s4 - 3 * s5, arrive = -4 * s3 + 7 * s4 - 3 * s5;
  const double bend = (s * s - 3 * s3 + 3 * s4 - s5) / 2, end_bend = (s3 - 2 * s4 + s5) / 2;
  y = a.y + rise * (b.y - a.y) + h * (leave * a.dy + arrive * b.dy) + h * h * (bend * a.ddy + end_bend * b.ddy);
}

}  // namespace

template <class S>
StateInterpolator<S>::StateInterpolator(const Tree<S>& tree, const CompiledTrajectory<S>& plan)
    : tree_(tree), plan_(plan), equations_(tree, plan.drive, plan.has_redundant_closures), state_(tree.nodes.size()) {
  x_.assign(static_cast<std::size_t>(std::max(tree.columns, equations_.rows())), 0);
}

template <class S>
bool StateInterpolator<S>::interpolate(const CoordinateSample& a, const CoordinateSample& b, double time) {
  interpolate_hermite(a, b, time, y_);
  plan_.prescribed_motion->at(time, Side::after, sample_);
  constexpr double residual_tolerance = 1e-12,
                   accepted_residual = 1e-7;  // scaled; round-off magnified by a singularity near by
  constexpr int max_corrections = 4;
  double worst = INFINITY;
  for (int k = 0; k <= max_corrections; ++k) {
    compute_poses(tree_, y_.data(), state_);
    equations_.evaluate(state_, y_.data(), sample_, x_.data());
    worst = 0;
    for (int r = 0; r < equations_.rows(); ++r) worst = std::max(worst, std::abs(x_[r]));
    if (worst <= residual_tolerance || k == max_corrections) break;
    if (!equations_.factorise(0)) return false;
    equations_.solve(x_.data());
    for (int c = 0; c < tree_.columns; ++c) y_[c] -= x_[c];
  }
  return worst <= accepted_residual;
}

template class StateInterpolator<Planar>;
template class StateInterpolator<Spatial>;

}  // namespace balance
