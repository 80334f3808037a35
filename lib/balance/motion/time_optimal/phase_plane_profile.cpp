#include "balance/motion/time_optimal/phase_plane_profile.hpp"

#include "balance/foundation/base/elementary.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace balance {
namespace {

constexpr double path_parameter_tolerance = 1e-12;    // of a step, as a part of the path
constexpr double path_rate_tolerance = 1e-11;         // of a step, relative
constexpr double path_acceleration_tolerance = 1e-7;  // of the quintic's s'' between nodes, relative
constexpr double kink_step_fraction = 1e-6;  // steps below this part of the arc's longest one step over kinks of s''
constexpr double min_profile_step_fraction = 1e-7;  // and below this part cannot go on: round-off would show in s''
constexpr double velocity_bound_tolerance = 1e-13;  // of its x
constexpr double difference_step = 1e-5;            // of a stretch: for the slope of the ceiling
constexpr double target_step_fraction = 0.05;       // of a step: what it falls short of its target by is added to it
constexpr int max_steps = 20000;

struct PathState {
  double s = 0, v = 0;
};

/// Dormand and Prince, 1980: fifth order, the fourth embedded.
constexpr std::array<std::array<double, 6>, 6> dormand_prince_stages{
    {{1.0 / 5},
     {3.0 / 40, 9.0 / 40},
     {44.0 / 45, -56.0 / 15, 32.0 / 9},
     {19372.0 / 6561, -25360.0 / 2187, 64448.0 / 6561, -212.0 / 729},
     {9017.0 / 3168, -355.0 / 33, 46732.0 / 5247, 49.0 / 176, -5103.0 / 18656},
     {35.0 / 384, 0, 500.0 / 1113, 125.0 / 192, -2187.0 / 6784, 11.0 / 84}}};
constexpr std::array<double, 7> dormand_prince_error_weights{71.0 / 57600,      0,          -71.0 / 16695, 71.0 / 1920,
                                                             -17253.0 / 339200, 22.0 / 525, -1.0 / 40};

class PhasePlaneIntegrator {
 public:
  PhasePlaneIntegrator(AccelerationLimits& allowed, const SmoothInterval& stretch, ProfileKind edge, double until,
                       const StepCallback& watcher, double under, VelocityProfile& arc)
      : allowed_(allowed),
        stretch_(stretch),
        edge_(edge),
        sign_(edge == ProfileKind::decelerate ? -1 : 1),
        target_(until),
        watcher_(watcher),
        velocity_margin_(under),
        arc_(arc) {}

  IntegrationEnd run() {
    if (sign_ * (target_ - arc_.back().s) <= 0) return IntegrationEnd::reached_target;
    if (edge_ != ProfileKind::slide && velocity_bound_excess(arc_.back()) > 1e-9) return IntegrationEnd::infeasible;
    ProfilePoint first = arc_.back();
    if (!evaluate(first)) return end_;
    if (edge_ == ProfileKind::accelerate && velocity_margin_ == 0 && can_follow_velocity_bound(first))
      return IntegrationEnd::hit_velocity_bound;
    if (arc_.size() > 1)
      arc_.push_back(first);  // the same place with s'' on this side of it
    else
      arc_.back() = first;
    if (edge_ != ProfileKind::slide && arc_.back().v == 0 && !(sign_ * arc_.back().u > 0))
      return IntegrationEnd::infeasible_start;
    double h = first_step();
    longest_ = h;
    for (int step = 0; step < max_steps; ++step) {
      ProfilePoint next;
      end_ = IntegrationEnd::reached_target;
      if (h < min_profile_step_fraction * longest_ || allowed_.has_reached_evaluation_limit())
        return IntegrationEnd::infeasible;
      h = std::min(h, time_left());
      bool last = false;
      bool right = try_step(h, next);
      if (right && sign_ * (next.s - target_) > -target_step_fraction * std::abs(next.s - arc_.back().s))
        last = right = shorten_to_target(h, next);
      if (!right) {
        h /= 4;
        if (h < min_profile_step_fraction * longest_)
          return end_ == IntegrationEnd::reached_target ? IntegrationEnd::infeasible : end_;
        continue;
      }
      if (error_ > 1 && h > kink_step_fraction * longest_) {
        h *= std::clamp(0.9 * elementary::pow(error_, -0.2), 0.15, 0.9);
        continue;
      }
      const bool capped = edge_ != ProfileKind::slide && velocity_bound_excess(next) > velocity_bound_tolerance;
      if (capped && !shorten_to_velocity_bound(h, next)) {
        h /= 4;
        if (h < min_profile_step_fraction * longest_) return IntegrationEnd::infeasible;
        continue;
      }
      arc_.push_back(next);
      if (watcher_ && watcher_(arc_[arc_.size() - 2], arc_.back())) return IntegrationEnd::stopped_by_callback;
      if (capped) return IntegrationEnd::hit_velocity_bound;
      if (last) return IntegrationEnd::reached_target;
      longest_ = std::max(longest_, h);
      h *= std::clamp(0.9 * elementary::pow(std::max(error_, 1e-12), -0.2), 0.3, 4.0);
    }
    return IntegrationEnd::infeasible;
  }

 private:
  /// To the target at the present s'': longer steps would ask for places beyond it.
  double time_left() const {
    const ProfilePoint& now = arc_.back();
    const double way = std::abs(target_ - now.s), gain = sign_ * now.u;
    const double square = now.v * now.v + 2 * gain * way;
    return square > 0 ? 2 * way / (now.v + std::sqrt(square)) : now.v > 0 ? 2 * way / now.v : INFINITY;
  }

  /// s'' and its row at a node. @return false: there is none
  bool evaluate(ProfilePoint& node) {
    allowed_.move_to(node.s, stretch_.first_panel, stretch_.last_panel);
    const double x = node.v * node.v, beyond = 0.05 * (stretch_.end - stretch_.begin);
    if (!(node.s > stretch_.begin - beyond && node.s < stretch_.end + beyond) || !std::isfinite(x))
      return end_with(IntegrationEnd::infeasible);
    if (edge_ == ProfileKind::slide) return evaluate_on_velocity_bound(node);
    const AccelerationInterval interval = allowed_.bounds_by_acceleration_rows(x);
    if (interval.is_empty()) return end_with(IntegrationEnd::infeasible);
    node.u = edge_ == ProfileKind::decelerate ? interval.lower : interval.upper;
    node.row = edge_ == ProfileKind::decelerate ? interval.lower_row : interval.upper_row;
    if (!std::isfinite(node.u)) return end_with(IntegrationEnd::unbounded);
    width_ = std::isfinite(interval.upper - interval.lower) ? interval.upper - interval.lower : std::abs(node.u);
    return true;
  }

  bool evaluate_on_velocity_bound(ProfilePoint& node) {
    if (velocity_margin_ > 0) return evaluate_below_max_velocity(node);
    const VelocityBound cap = allowed_.direct_velocity_bound();
    if (cap.row < 0 || !(cap.x > 0)) return end_with(IntegrationEnd::infeasible);
    node.v = std::sqrt(cap.x);
    node.u = allowed_.acceleration_on_bound(cap.row, cap.x);
    node.row = cap.row;
    const AccelerationInterval interval = allowed_.bounds_by_acceleration_rows(cap.x);
    if (interval.is_empty()) return end_with(IntegrationEnd::infeasible);
    width_ = std::isfinite(interval.upper - interval.lower) ? interval.upper - interval.lower : std::abs(node.u);
    const double slack = 1e-9 * std::abs(node.u) + 1e-12 * width_;
    if (node.u > interval.upper + slack) return end_with(IntegrationEnd::left_velocity_bound);
    if (node.u < interval.lower - slack) return end_with(IntegrationEnd::infeasible);
    return true;
  }

  bool end_with(IntegrationEnd end) {
    end_ = end;
    return false;
  }

  /// As long as it takes to run through a hundredth of the stretch from rest, or at the present rate.
  double first_step() const {
    const ProfilePoint& now = arc_.back();
    const double way = 1e-2 * std::min(std::abs(target_ - now.s), stretch_.end - stretch_.begin);
    const double by_bend = now.u != 0 ? std::sqrt(2 * way / std::abs(now.u)) : INFINITY;
    const double by_rate = now.v != 0 ? way / now.v : INFINITY;
    const double h = std::min(by_bend, by_rate);
    return std::isfinite(h) ? h : 1e-3;
  }

  bool try_step(double h, ProfilePoint& next) {
    const ProfilePoint& now = arc_.back();
    std::array<PathState, 7> k{};
    k[0] = {sign_ * now.v, sign_ * now.u};
    for (std::size_t i = 0; i < dormand_prince_stages.size(); ++i) {
      PathState at{now.s, now.v};
      for (std::size_t j = 0; j <= i; ++j) {
        at.s += h * dormand_prince_stages[i][j] * k[j].s;
        at.v += h * dormand_prince_stages[i][j] * k[j].v;
      }
      next = {now.t + h, at.s, std::max(at.v, 0.0), 0, -1};
      if (!evaluate(next)) return false;
      k[i + 1] = {sign_ * next.v, sign_ * next.u};
    }
    PathState error;
    for (std::size_t i = 0; i < k.size(); ++i) {
      error.s += h * dormand_prince_error_weights[i] * k[i].s;
      error.v += h * dormand_prince_error_weights[i] * k[i].v;
    }
    error_ = std::max(std::abs(error.s) / path_parameter_tolerance,
                      std::abs(error.v) / (path_rate_tolerance * std::max(next.v, now.v) + 1e-300));
    return check_interpolation(now, next);
  }

  /// Adds how far the quintic's s'' is off between nodes: a kink may hide from one place or two. @return false if nothing is
  /// allowed there
  bool check_interpolation(const ProfilePoint& now, const ProfilePoint& next) {
    for (const double part : {0.2, 0.4, 0.6, 0.85}) {
      ProfilePoint inside = interpolate_inside(now, next, part);
      const double bend = inside.u, size = std::max({std::abs(now.u), std::abs(next.u), width_});
      if (!evaluate(inside)) return false;
      error_ = std::max(error_, std::abs(inside.u - bend) / (path_acceleration_tolerance * size));
    }
    return true;
  }

  ProfilePoint interpolate_inside(const ProfilePoint& a, const ProfilePoint& b, double part) const {
    if (sign_ > 0) return interpolate(a, b, a.t + part * (b.t - a.t));
    ProfilePoint first = b, second = a;  // in the order of time
    first.t = 0;
    second.t = b.t - a.t;
    return interpolate(first, second, part * second.t);
  }

  /// Shortens a step that goes too far so that it ends where it should.
  bool shorten_to_target(double h, ProfilePoint& next) {
    const ProfilePoint& now = arc_.back();
    double shorter = h;
    for (int iteration = 0; iteration < 30; ++iteration) {
      const double miss = sign_ * (next.s - target_);
      if (std::abs(miss) <= 1e-15 || next.v <= 0) break;
      shorter -= miss / next.v;
      if (!(shorter > 0)) shorter = h / 2;
      if (!try_step(shorter, next)) return false;
    }
    next.s = target_;
    return next.t > now.t;
  }

  /// How far beyond the cap a node is, as a part of it.
  double velocity_bound_excess(const ProfilePoint& node) {
    allowed_.move_to(node.s, stretch_.first_panel, stretch_.last_panel);
    const double x = velocity_margin_ > 0 ? current_max_velocity() : allowed_.direct_velocity_bound().x;
    return node.v * node.v / x - 1;
  }

  double current_max_velocity() {
    guess_ = allowed_.max_velocity(guess_).x;
    return (1 - velocity_margin_) * guess_;
  }

  /// Just under the ceiling where the rows with a leave a single s'' there, which may happen to follow it.
  bool evaluate_below_max_velocity(ProfilePoint& node) {
    const double step = difference_step * (stretch_.end - stretch_.begin), place = node.s;
    const auto at = [&](double s) {
      allowed_.move_to(s, stretch_.first_panel, stretch_.last_panel);
      return current_max_velocity();
    };
    const double before = at(place - step), after = at(place + step), x = at(place);
    if (!std::isfinite(before + after + x) || !(x > 0)) return end_with(IntegrationEnd::infeasible);
    node.v = std::sqrt(x);
    node.u = (after - before) / (4 * step);
    const AccelerationInterval interval = allowed_.bounds(x);
    if (interval.is_empty() || node.u < interval.lower) return end_with(IntegrationEnd::infeasible);
    if (node.u > interval.upper) return end_with(IntegrationEnd::left_velocity_bound);
    node.row = interval.upper_row;
    width_ = std::max(std::abs(node.u), x / (stretch_.end - stretch_.begin));
    return true;
  }

  /// Whether a node on the cap can go on along it.
  bool can_follow_velocity_bound(const ProfilePoint& node) {
    const VelocityBound cap = allowed_.direct_velocity_bound();
    return cap.row >= 0 && std::abs(node.v * node.v - cap.x) <= 1e-10 * cap.x &&
           node.u >= allowed_.acceleration_on_bound(cap.row, cap.x);
  }

  /// Shortens a step that goes beyond the cap so that it ends on it.
  bool shorten_to_velocity_bound(double h, ProfilePoint& next) {
    double low = 0, high = h;
    for (int halving = 0; halving < 60 && high - low > 1e-15 * h; ++halving) {
      const double middle = (low + high) / 2;
      if (!try_step(middle, next)) return false;
      (velocity_bound_excess(next) > 0 ? high : low) = middle;
    }
    return low > 0 && try_step(low, next);
  }

  AccelerationLimits& allowed_;
  const SmoothInterval& stretch_;
  ProfileKind edge_;
  double sign_, target_;
  const StepCallback& watcher_;
  double velocity_margin_;
  double guess_ = 0;  ///< of the ceiling
  VelocityProfile& arc_;
  IntegrationEnd end_ = IntegrationEnd::reached_target;
  double error_ = 0, width_ = 0, longest_ = 0;
};

}  // namespace

ProfilePoint interpolate(const ProfilePoint& a, const ProfilePoint& b, double t) {
  const PhasePoint here = interpolate_quintic({a.t, a.s, a.v, a.u}, {b.t, b.s, b.v, b.u}, t);
  return {t, here.s, here.v, here.u, a.row};
}

ProfilePoint interpolate_at_parameter(const ProfilePoint& a, const ProfilePoint& b, double s) {
  double low = a.t, high = b.t;
  double t = a.t + (b.t - a.t) * std::clamp((s - a.s) / (b.s - a.s), 0.0, 1.0);
  for (int iteration = 0; iteration < 60; ++iteration) {
    const ProfilePoint here = interpolate(a, b, t);
    (here.s < s ? low : high) = t;
    const double next = here.v > 0 ? t - (here.s - s) / here.v : INFINITY;
    const double better = next > low && next < high ? next : (low + high) / 2;
    if (std::abs(better - t) <= 1e-16 * std::abs(b.t)) break;
    t = better;
  }
  ProfilePoint found = interpolate(a, b, t);
  found.s = s;
  return found;
}

IntegrationEnd integrate_profile(AccelerationLimits& allowed, const SmoothInterval& stretch, ProfileKind edge,
                                 double until, const StepCallback& watcher, VelocityProfile& arc, double under) {
  return PhasePlaneIntegrator(allowed, stretch, edge, until, watcher, under, arc).run();
}

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
