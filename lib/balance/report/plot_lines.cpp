#include "balance/report/plot_lines.hpp"

#include "balance/base/extrema.hpp"

#include <algorithm>
#include <cmath>

namespace balance {
namespace {

constexpr double jump_slope_ratio =
    6;  // a step this many times those around it is no smooth motion: theirs differ by the
        // third derivative only
constexpr double jump_epsilon = 0.01;              // of the range; smaller steps are round-off
constexpr double invisible_step_tolerance = 1e-4;  // of the range: an upright step that nobody would see

bool jumps_at(const VectorX& values, Eigen::Index k, double range) {
  const auto step = [&](Eigen::Index i) {
    return i < 1 || i >= values.size() ? 0.0 : std::abs(values[i] - values[i - 1]);
  };
  const double around = std::max({step(k - 2), step(k - 1), step(k + 1), step(k + 2)});
  return step(k) > jump_epsilon * range && step(k) > jump_slope_ratio * around;
}

/// What the samples before k lead to at k: through the last three of them that no other jump parts.
double value_before(const VectorX& values, Eigen::Index k, Eigen::Index first) {
  const Eigen::Index known = std::min<Eigen::Index>(k - first, 3);
  const auto back = [&](Eigen::Index i) { return values[k - i]; };
  if (known == 3) return 3 * back(1) - 3 * back(2) + back(3);
  return known == 2 ? 2 * back(1) - back(2) : back(1);
}

}  // namespace

std::vector<Eigen::Index> find_sampled_jumps(const RunResult& result) {
  std::vector<Eigen::Index> jumps;
  const Samples& all = result.joint_acceleration;
  for (Eigen::Index column = 0; column < all.cols(); ++column) {
    const VectorX values = all.col(column);
    if (values.size() < 4) continue;
    const double range = max_coefficient(values) - min_coefficient(values);
    // Ends have neighbours on one side only, which is too little to tell a jump from the motion.
    for (Eigen::Index k = 2; k + 1 < values.size(); ++k)
      if (jumps_at(values, k, range)) jumps.push_back(k);
  }
  std::sort(jumps.begin(), jumps.end());
  jumps.erase(std::unique(jumps.begin(), jumps.end()), jumps.end());
  return jumps;
}

std::vector<PlotPoint> trace_values(const VectorX& x, const VectorX& values, const std::vector<Eigen::Index>& jumps) {
  std::vector<PlotPoint> points;
  const double range = values.size() > 0 ? max_coefficient(values) - min_coefficient(values) : 0;
  Eigen::Index first = 0;
  auto next = jumps.begin();
  for (Eigen::Index k = 0; k < values.size(); ++k) {
    if (next != jumps.end() && *next == k) {
      const double before = value_before(values, k, first);
      if (std::abs(before - values[k]) > invisible_step_tolerance * range) points.push_back({x[k], before});
      first = k;
      ++next;
    }
    points.push_back({x[k], values[k]});
  }
  return points;
}

std::vector<PlotPoint> decimate_series(std::vector<PlotPoint> points, std::size_t most) {
  if (points.size() <= most) return points;
  const std::size_t stretches = std::max<std::size_t>(most / 4, 1);
  std::vector<PlotPoint> kept;
  for (std::size_t i = 0; i < stretches; ++i) {
    const auto begin = points.begin() + static_cast<std::ptrdiff_t>(i * points.size() / stretches);
    const auto end = points.begin() + static_cast<std::ptrdiff_t>((i + 1) * points.size() / stretches);
    const auto [low, high] =
        std::minmax_element(begin, end, [](const PlotPoint& a, const PlotPoint& b) { return a.y < b.y; });
    std::vector<std::vector<PlotPoint>::iterator> places = {begin, low, high, end - 1};
    std::sort(places.begin(), places.end());
    places.erase(std::unique(places.begin(), places.end()), places.end());
    for (const auto place : places) kept.push_back(*place);
  }
  return kept;
}

std::vector<PlotPoint> decimate_path(std::vector<PlotPoint> points, std::size_t most) {
  if (points.size() <= most || most < 2) return points;
  std::vector<PlotPoint> kept;
  for (std::size_t i = 0; i < most; ++i) kept.push_back(points[i * (points.size() - 1) / (most - 1)]);
  return kept;
}

}  // namespace balance
