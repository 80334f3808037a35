#include "balance/timing/stretches.hpp"

#include <algorithm>
#include <cmath>

namespace balance {
namespace {

/// Of a stretch: how far the expansion at a point of zero inertia is trusted. Its error is of third order in the place.
constexpr double expansion_step_fraction = 1e-3;

}  // namespace

std::vector<SegmentRange> split_into_segments(const PathModel& model) {
  std::vector<SegmentRange> legs;
  const std::vector<Panel>& panels = model.value.panels();
  for (std::size_t i = 0; i + 1 < model.segment_ends.size(); ++i) {
    SegmentRange leg{model.segment_ends[i], model.segment_ends[i + 1], {}};
    double from = leg.begin;
    const auto add = [&](double to) {
      // a zero of a lies inside a panel, jumps at the ends of panels
      SmoothInterval stretch;
      stretch.begin = from;
      stretch.end = to;
      stretch.first_panel = model.value.find_panel(from, 0, panels.size());
      stretch.last_panel = stretch.first_panel + 1;
      while (stretch.last_panel < panels.size() && panels[stretch.last_panel].begin < to) ++stretch.last_panel;
      const auto vanishes = [&](double place) {
        return std::find(model.zero_inertia_points.begin(), model.zero_inertia_points.end(), place) !=
               model.zero_inertia_points.end();
      };
      stretch.has_zero_inertia_begin = vanishes(from);
      stretch.has_zero_inertia_end = vanishes(to);
      leg.smooth_intervals.push_back(stretch);
      from = to;
    };
    for (const double station : model.breakpoints)
      if (station > leg.begin && station < leg.end) add(station);
    add(leg.end);
    legs.push_back(std::move(leg));
  }
  return legs;
}

/// With x' = 2u the row's value leaves its bound like (a' + 2b)(u − u_r) δs on both sides: where a' + 2b > 0, s'' must be at least
/// u_r before the place and at most u_r behind it, which is what the arc wants to go beyond; where it is negative the other way round.
ZeroInertia::Start ZeroInertia::profile_start(const AccelerationLimits& allowed, int row, double x, int side) {
  const AccelerationInterval others = allowed.bounds(x * (1 - 1e-9));
  if (others.is_empty()) return {};
  const double steep = allowed.zero_inertia_slope(row, x), own = allowed.acceleration_on_bound(row, x);
  if (steep > 0) {
    const double u = side < 0 ? std::max(own, others.lower) : std::min(own, others.upper);
    if (u < others.lower || u > others.upper) return {};
    return {true, u == own, u, u == own ? allowed.acceleration_slope_on_bound(row, x, u) : 0};
  }
  const double u = side < 0 ? others.lower : others.upper;
  return {side < 0 ? u <= own : u >= own, false, u, 0};
}

bool step_from_zero_inertia(AccelerationLimits& allowed, const SmoothInterval& stretch, const ZeroInertia::Start& start,
                            int row, int side, VelocityProfile& arc) {
  const ProfilePoint from = arc.back();
  const double way = expansion_step_fraction * std::min(stretch.end - stretch.begin, 0.05), ds = side * way;
  const auto x_at = [&](double d) { return from.v * from.v + d * (2 * start.u + d * start.acceleration_slope); };
  const double x = x_at(ds);
  if (!(x > 0) || !(x_at(ds / 2) > 0)) return false;
  // Simpson's rule of dt = ds/√x
  const double dt = way / 6 * (1 / from.v + 4 / std::sqrt(x_at(ds / 2)) + 1 / std::sqrt(x));
  ProfilePoint next{from.t + dt, from.s + ds, std::sqrt(x), start.u + ds * start.acceleration_slope, row};
  allowed.move_to(next.s, stretch.first_panel, stretch.last_panel);
  const AccelerationInterval interval = allowed.bounds(x * (1 - 1e-9));
  if (interval.is_empty()) return false;
  const double limit = side < 0 ? interval.lower : interval.upper;
  const int by = side < 0 ? interval.lower_row : interval.upper_row;
  if (by != row || std::abs(limit - next.u) > 0.05 * (std::abs(limit) + std::abs(next.u))) return false;
  arc.back().u = start.u;
  arc.back().row = row;
  arc.push_back(next);
  return true;
}

}  // namespace balance
