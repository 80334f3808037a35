#include "balance/timing/stretches.hpp"

#include <algorithm>
#include <cmath>

namespace balance {
namespace {

/// Of a stretch: how far the expansion at a point of zero inertia is trusted. Its error is of third order in the place.
constexpr double first_way = 1e-3;

}  // namespace

std::vector<LegOfPath> cut_legs(const PathModel& model) {
  std::vector<LegOfPath> legs;
  const std::vector<Panel>& panels = model.value.panels();
  for (std::size_t i = 0; i + 1 < model.leg_ends.size(); ++i) {
    LegOfPath leg{model.leg_ends[i], model.leg_ends[i + 1], {}};
    double from = leg.begin;
    const auto add = [&](double to) {
      // a zero of a lies inside a panel, jumps at the ends of panels
      Smooth stretch;
      stretch.begin = from;
      stretch.end = to;
      stretch.first_panel = model.value.panel_at(from, 0, panels.size());
      stretch.last_panel = stretch.first_panel + 1;
      while (stretch.last_panel < panels.size() && panels[stretch.last_panel].begin < to) ++stretch.last_panel;
      const auto vanishes = [&](double place) {
        return std::find(model.vanishing.begin(), model.vanishing.end(), place) != model.vanishing.end();
      };
      stretch.vanishes_at_begin = vanishes(from);
      stretch.vanishes_at_end = vanishes(to);
      leg.stretches.push_back(stretch);
      from = to;
    };
    for (const double station : model.stations)
      if (station > leg.begin && station < leg.end) add(station);
    add(leg.end);
    legs.push_back(std::move(leg));
  }
  return legs;
}

/// With x' = 2u the row's value leaves its bound like (a' + 2b)(u − u_r) δs on both sides: where a' + 2b > 0, s'' must be at least
/// u_r before the place and at most u_r behind it, which is what the arc wants to go beyond; where it is negative the other way round.
ZeroInertia::Start ZeroInertia::start(const Allowed& allowed, int row, double x, int side) {
  const Interval others = allowed.at(x * (1 - 1e-9));
  if (others.empty()) return {};
  const double steep = allowed.steepness(row, x), own = allowed.along(row, x);
  if (steep > 0) {
    const double u = side < 0 ? std::max(own, others.low) : std::min(own, others.high);
    if (u < others.low || u > others.high) return {};
    return {true, u == own, u, u == own ? allowed.bend_along(row, x, u) : 0};
  }
  const double u = side < 0 ? others.low : others.high;
  return {side < 0 ? u <= own : u >= own, false, u, 0};
}

bool step_off(Allowed& allowed, const Smooth& stretch, const ZeroInertia::Start& start, int row, int side, Arc& arc) {
  const ArcNode from = arc.back();
  const double way = first_way * std::min(stretch.end - stretch.begin, 0.05), ds = side * way;
  const auto x_at = [&](double d) { return from.v * from.v + d * (2 * start.u + d * start.bend); };
  const double x = x_at(ds);
  if (!(x > 0) || !(x_at(ds / 2) > 0)) return false;
  // Simpson's rule of dt = ds/√x
  const double dt = way / 6 * (1 / from.v + 4 / std::sqrt(x_at(ds / 2)) + 1 / std::sqrt(x));
  ArcNode next{from.t + dt, from.s + ds, std::sqrt(x), start.u + ds * start.bend, row};
  allowed.go(next.s, stretch.first_panel, stretch.last_panel);
  const Interval interval = allowed.at(x * (1 - 1e-9));
  if (interval.empty()) return false;
  const double limit = side < 0 ? interval.low : interval.high;
  const int by = side < 0 ? interval.low_row : interval.high_row;
  if (by != row || std::abs(limit - next.u) > 0.05 * (std::abs(limit) + std::abs(next.u))) return false;
  arc.back().u = start.u;
  arc.back().row = row;
  arc.push_back(next);
  return true;
}

}  // namespace balance
