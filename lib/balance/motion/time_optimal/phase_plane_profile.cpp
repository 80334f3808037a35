#include "balance/motion/time_optimal/phase_plane_profile.hpp"

#include "balance/foundation/base/elementary.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace balance::time_optimal {
namespace {

constexpr double path_parameter_tolerance = 1e-12;    // per step, as a fraction of the path
constexpr double path_rate_tolerance = 1e-11;         // per step, relative
constexpr double path_acceleration_tolerance = 1e-7;  // of the quintic's s'' between nodes, relative
constexpr double kink_step_fraction = 1e-6;  // steps below this fraction of the longest step go over kinks of s''
constexpr double min_profile_step_fraction = 1e-7;  // below this fraction it fails: round-off would show in s''
constexpr double velocity_bound_tolerance = 1e-13;  // of x
constexpr double difference_step = 1e-5;            // of an interval: for the slope of the maximum velocity curve
constexpr double target_step_fraction = 0.05;       // of a step: those ending this close to the target reach it
constexpr int max_steps = 20000;

struct PathState {
  double s = 0, v = 0;
};

/// Dormand and Prince (1980): fifth order with an embedded fourth order.
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
  PhasePlaneIntegrator(AccelerationLimits& limits, const SmoothInterval& interval, ProfileKind kind, double target,
                       const StepCallback& callback, double velocity_margin, VelocityProfile& profile)
      : limits_(limits),
        interval_(interval),
        kind_(kind),
        sign_(kind == ProfileKind::decelerate ? -1 : 1),
        target_(target),
        callback_(callback),
        velocity_margin_(velocity_margin),
        profile_(profile) {}

  IntegrationEnd run() {
    if (sign_ * (target_ - profile_.back().s) <= 0) return IntegrationEnd::reached_target;
    if (kind_ != ProfileKind::slide && velocity_bound_excess(profile_.back()) > 1e-9) return IntegrationEnd::infeasible;
    ProfilePoint first = profile_.back();
    if (!evaluate(first)) return end_;
    if (kind_ == ProfileKind::accelerate && velocity_margin_ == 0 && can_follow_velocity_bound(first))
      return IntegrationEnd::hit_velocity_bound;
    if (profile_.size() > 1)
      profile_.push_back(first);  // the same point with s'' on this side
    else
      profile_.back() = first;
    if (kind_ != ProfileKind::slide && profile_.back().v == 0 && !(sign_ * profile_.back().u > 0))
      return IntegrationEnd::infeasible_start;
    double h = first_step();
    max_step_ = h;
    for (int step = 0; step < max_steps; ++step) {
      ProfilePoint next;
      end_ = IntegrationEnd::reached_target;
      if (h < min_profile_step_fraction * max_step_ || limits_.has_reached_evaluation_limit())
        return IntegrationEnd::infeasible;
      h = std::min(h, time_to_target());
      bool is_last = false;
      bool accepted = try_step(h, next);
      if (accepted && sign_ * (next.s - target_) > -target_step_fraction * std::abs(next.s - profile_.back().s))
        is_last = accepted = adjust_to_target(h, next);
      if (!accepted) {
        h /= 4;
        if (h < min_profile_step_fraction * max_step_)
          return end_ == IntegrationEnd::reached_target ? IntegrationEnd::infeasible : end_;
        continue;
      }
      if (error_ > 1 && h > kink_step_fraction * max_step_) {
        h *= std::clamp(0.9 * elementary::pow(error_, -0.2), 0.15, 0.9);
        continue;
      }
      const bool exceeds_bound = kind_ != ProfileKind::slide && velocity_bound_excess(next) > velocity_bound_tolerance;
      if (exceeds_bound && !shorten_to_velocity_bound(h, next)) {
        h /= 4;
        if (h < min_profile_step_fraction * max_step_) return IntegrationEnd::infeasible;
        continue;
      }
      profile_.push_back(next);
      if (callback_ && callback_(profile_[profile_.size() - 2], profile_.back()))
        return IntegrationEnd::stopped_by_callback;
      if (exceeds_bound) return IntegrationEnd::hit_velocity_bound;
      if (is_last) return IntegrationEnd::reached_target;
      max_step_ = std::max(max_step_, h);
      h *= std::clamp(0.9 * elementary::pow(std::max(error_, 1e-12), -0.2), 0.3, 4.0);
    }
    return IntegrationEnd::infeasible;
  }

 private:
  /// Time to the target at the current s''. Longer steps would evaluate points beyond it.
  double time_to_target() const {
    const ProfilePoint& current = profile_.back();
    const double distance = std::abs(target_ - current.s), acceleration = sign_ * current.u;
    const double squared_end_rate = current.v * current.v + 2 * acceleration * distance;
    return squared_end_rate > 0 ? 2 * distance / (current.v + std::sqrt(squared_end_rate))
           : current.v > 0      ? 2 * distance / current.v
                                : INFINITY;
  }

  /// Sets s'' and its row at a node. @return false if no s'' is feasible
  bool evaluate(ProfilePoint& node) {
    limits_.move_to(node.s, interval_.first_panel, interval_.last_panel);
    const double x = node.v * node.v, extrapolation = 0.05 * (interval_.end - interval_.begin);
    if (!(node.s > interval_.begin - extrapolation && node.s < interval_.end + extrapolation) || !std::isfinite(x))
      return end_with(IntegrationEnd::infeasible);
    if (kind_ == ProfileKind::slide) return evaluate_on_velocity_bound(node);
    const AccelerationInterval interval = limits_.bounds_by_acceleration_rows(x);
    if (interval.is_empty()) return end_with(IntegrationEnd::infeasible);
    node.u = kind_ == ProfileKind::decelerate ? interval.lower : interval.upper;
    node.row = kind_ == ProfileKind::decelerate ? interval.lower_row : interval.upper_row;
    if (!std::isfinite(node.u)) return end_with(IntegrationEnd::unbounded);
    acceleration_scale_ =
        std::isfinite(interval.upper - interval.lower) ? interval.upper - interval.lower : std::abs(node.u);
    return true;
  }

  bool evaluate_on_velocity_bound(ProfilePoint& node) {
    if (velocity_margin_ > 0) return evaluate_below_max_velocity(node);
    const VelocityBound velocity_bound = limits_.direct_velocity_bound();
    if (velocity_bound.row < 0 || !(velocity_bound.x > 0)) return end_with(IntegrationEnd::infeasible);
    node.v = std::sqrt(velocity_bound.x);
    node.u = limits_.acceleration_on_bound(velocity_bound.row, velocity_bound.x);
    node.row = velocity_bound.row;
    const AccelerationInterval interval = limits_.bounds_by_acceleration_rows(velocity_bound.x);
    if (interval.is_empty()) return end_with(IntegrationEnd::infeasible);
    acceleration_scale_ =
        std::isfinite(interval.upper - interval.lower) ? interval.upper - interval.lower : std::abs(node.u);
    const double slack = 1e-9 * std::abs(node.u) + 1e-12 * acceleration_scale_;
    if (node.u > interval.upper + slack) return end_with(IntegrationEnd::left_velocity_bound);
    if (node.u < interval.lower - slack) return end_with(IntegrationEnd::infeasible);
    return true;
  }

  bool end_with(IntegrationEnd end) {
    end_ = end;
    return false;
  }

  /// Time to traverse a hundredth of the interval from rest, or at the current rate.
  double first_step() const {
    const ProfilePoint& current = profile_.back();
    const double distance = 1e-2 * std::min(std::abs(target_ - current.s), interval_.end - interval_.begin);
    const double acceleration_step = current.u != 0 ? std::sqrt(2 * distance / std::abs(current.u)) : INFINITY;
    const double rate_step = current.v != 0 ? distance / current.v : INFINITY;
    const double h = std::min(acceleration_step, rate_step);
    return std::isfinite(h) ? h : 1e-3;
  }

  bool try_step(double h, ProfilePoint& next) {
    const ProfilePoint& current = profile_.back();
    std::array<PathState, 7> k{};
    k[0] = {sign_ * current.v, sign_ * current.u};
    for (std::size_t i = 0; i < dormand_prince_stages.size(); ++i) {
      PathState stage{current.s, current.v};
      for (std::size_t j = 0; j <= i; ++j) {
        stage.s += h * dormand_prince_stages[i][j] * k[j].s;
        stage.v += h * dormand_prince_stages[i][j] * k[j].v;
      }
      next = {current.t + h, stage.s, std::max(stage.v, 0.0), 0, -1};
      if (!evaluate(next)) return false;
      k[i + 1] = {sign_ * next.v, sign_ * next.u};
    }
    PathState error;
    for (std::size_t i = 0; i < k.size(); ++i) {
      error.s += h * dormand_prince_error_weights[i] * k[i].s;
      error.v += h * dormand_prince_error_weights[i] * k[i].v;
    }
    error_ = std::max(std::abs(error.s) / path_parameter_tolerance,
                      std::abs(error.v) / (path_rate_tolerance * std::max(next.v, current.v) + 1e-300));
    return check_interpolation(current, next);
  }

  /// Adds the error of the quintic's s'' between nodes. One or two points could miss a kink.
  /// @return false if no s'' is feasible at one of the points
  bool check_interpolation(const ProfilePoint& current, const ProfilePoint& next) {
    for (const double fraction : {0.2, 0.4, 0.6, 0.85}) {
      ProfilePoint interpolated = interpolate_inside(current, next, fraction);
      const double quintic_u = interpolated.u,
                   scale = std::max({std::abs(current.u), std::abs(next.u), acceleration_scale_});
      if (!evaluate(interpolated)) return false;
      error_ = std::max(error_, std::abs(interpolated.u - quintic_u) / (path_acceleration_tolerance * scale));
    }
    return true;
  }

  ProfilePoint interpolate_inside(const ProfilePoint& a, const ProfilePoint& b, double fraction) const {
    if (sign_ > 0) return interpolate(a, b, a.t + fraction * (b.t - a.t));
    ProfilePoint first = b, second = a;  // in order of time
    first.t = 0;
    second.t = b.t - a.t;
    return interpolate(first, second, fraction * second.t);
  }

  /// Changes the length of a step so that it ends at the target.
  bool adjust_to_target(double h, ProfilePoint& next) {
    const ProfilePoint& current = profile_.back();
    double step = h;
    for (int iteration = 0; iteration < 30; ++iteration) {
      const double overshoot = sign_ * (next.s - target_);
      if (std::abs(overshoot) <= 1e-15 || next.v <= 0) break;
      step -= overshoot / next.v;
      if (!(step > 0)) step = h / 2;
      if (!try_step(step, next)) return false;
    }
    next.s = target_;
    return next.t > current.t;
  }

  /// Relative excess of a node over the velocity bound.
  double velocity_bound_excess(const ProfilePoint& node) {
    limits_.move_to(node.s, interval_.first_panel, interval_.last_panel);
    const double x = velocity_margin_ > 0 ? current_max_velocity() : limits_.direct_velocity_bound().x;
    return node.v * node.v / x - 1;
  }

  double current_max_velocity() {
    max_velocity_guess_ = limits_.max_velocity(max_velocity_guess_).x;
    return (1 - velocity_margin_) * max_velocity_guess_;
  }

  /// Stays just below the maximum velocity curve, where the rows with a leave a single s'' that may happen to follow
  /// it.
  bool evaluate_below_max_velocity(ProfilePoint& node) {
    const double step = difference_step * (interval_.end - interval_.begin), centre = node.s;
    const auto at = [&](double s) {
      limits_.move_to(s, interval_.first_panel, interval_.last_panel);
      return current_max_velocity();
    };
    const double before = at(centre - step), after = at(centre + step), x = at(centre);
    if (!std::isfinite(before + after + x) || !(x > 0)) return end_with(IntegrationEnd::infeasible);
    node.v = std::sqrt(x);
    node.u = (after - before) / (4 * step);
    const AccelerationInterval interval = limits_.bounds(x);
    if (interval.is_empty() || node.u < interval.lower) return end_with(IntegrationEnd::infeasible);
    if (node.u > interval.upper) return end_with(IntegrationEnd::left_velocity_bound);
    node.row = interval.upper_row;
    acceleration_scale_ = std::max(std::abs(node.u), x / (interval_.end - interval_.begin));
    return true;
  }

  /// Whether a node on the velocity bound can continue along it.
  bool can_follow_velocity_bound(const ProfilePoint& node) {
    const VelocityBound velocity_bound = limits_.direct_velocity_bound();
    return velocity_bound.row >= 0 && std::abs(node.v * node.v - velocity_bound.x) <= 1e-10 * velocity_bound.x &&
           node.u >= limits_.acceleration_on_bound(velocity_bound.row, velocity_bound.x);
  }

  /// Shortens a step beyond the velocity bound so that it ends on it.
  bool shorten_to_velocity_bound(double h, ProfilePoint& next) {
    double low = 0, high = h;
    for (int halving = 0; halving < 60 && high - low > 1e-15 * h; ++halving) {
      const double middle = (low + high) / 2;
      if (!try_step(middle, next)) return false;
      (velocity_bound_excess(next) > 0 ? high : low) = middle;
    }
    return low > 0 && try_step(low, next);
  }

  AccelerationLimits& limits_;
  const SmoothInterval& interval_;
  ProfileKind kind_;
  double sign_, target_;
  const StepCallback& callback_;
  double velocity_margin_;
  double max_velocity_guess_ = 0;  ///< of x
  VelocityProfile& profile_;
  IntegrationEnd end_ = IntegrationEnd::reached_target;
  double error_ = 0, acceleration_scale_ = 0, max_step_ = 0;
};

}  // namespace

ProfilePoint interpolate(const ProfilePoint& a, const ProfilePoint& b, double t) {
  const trajectory::PhasePoint point = trajectory::interpolate_quintic({a.t, a.s, a.v, a.u}, {b.t, b.s, b.v, b.u}, t);
  return {t, point.s, point.v, point.u, a.row};
}

ProfilePoint interpolate_at_parameter(const ProfilePoint& a, const ProfilePoint& b, double s) {
  double low = a.t, high = b.t;
  double t = a.t + (b.t - a.t) * std::clamp((s - a.s) / (b.s - a.s), 0.0, 1.0);
  for (int iteration = 0; iteration < 60; ++iteration) {
    const ProfilePoint trial = interpolate(a, b, t);
    (trial.s < s ? low : high) = t;
    const double newton_t = trial.v > 0 ? t - (trial.s - s) / trial.v : INFINITY;
    const double next_t = newton_t > low && newton_t < high ? newton_t : (low + high) / 2;
    if (std::abs(next_t - t) <= 1e-16 * std::abs(b.t)) break;
    t = next_t;
  }
  ProfilePoint point = interpolate(a, b, t);
  point.s = s;
  return point;
}

IntegrationEnd integrate_profile(AccelerationLimits& limits, const SmoothInterval& interval, ProfileKind kind,
                                 double target, const StepCallback& callback, VelocityProfile& profile,
                                 double velocity_margin) {
  return PhasePlaneIntegrator(limits, interval, kind, target, callback, velocity_margin, profile).run();
}

namespace {

/// Fraction of an interval in which the expansion at a zero-inertia point is used. Its error is of third order in δs.
constexpr double expansion_step_fraction = 1e-3;

}  // namespace

std::vector<SegmentRange> split_into_segments(const PathModel& model) {
  std::vector<SegmentRange> legs;
  const std::vector<numerics::Panel>& panels = model.value.panels();
  for (std::size_t i = 0; i + 1 < model.segment_ends.size(); ++i) {
    SegmentRange leg{model.segment_ends[i], model.segment_ends[i + 1], {}};
    double from = leg.begin;
    const auto add_interval = [&](double to) {
      // a zero of a is inside a panel, jumps are at the ends of panels
      SmoothInterval interval;
      interval.begin = from;
      interval.end = to;
      interval.first_panel = model.value.find_panel(from, 0, panels.size());
      interval.last_panel = interval.first_panel + 1;
      while (interval.last_panel < panels.size() && panels[interval.last_panel].begin < to) ++interval.last_panel;
      const auto is_zero_inertia_point = [&](double s) {
        return std::find(model.zero_inertia_points.begin(), model.zero_inertia_points.end(), s) !=
               model.zero_inertia_points.end();
      };
      interval.has_zero_inertia_begin = is_zero_inertia_point(from);
      interval.has_zero_inertia_end = is_zero_inertia_point(to);
      leg.smooth_intervals.push_back(interval);
      from = to;
    };
    for (const double breakpoint : model.breakpoints)
      if (breakpoint > leg.begin && breakpoint < leg.end) add_interval(breakpoint);
    add_interval(leg.end);
    legs.push_back(std::move(leg));
  }
  return legs;
}

/// With x' = 2u the row's value leaves its bound like (a' + 2b)(u − u_r) δs on both sides. If a' + 2b > 0, s'' must be
/// at least u_r before the point and at most u_r after it; the profile is at this limit. If a' + 2b < 0, it is the
/// other way round.
ZeroInertia::Start ZeroInertia::profile_start(const AccelerationLimits& limits, int row, double x, int side) {
  const AccelerationInterval other_rows = limits.bounds(x * (1 - 1e-9));
  if (other_rows.is_empty()) return {};
  const double slope = limits.zero_inertia_slope(row, x), row_u = limits.acceleration_on_bound(row, x);
  if (slope > 0) {
    const double u = side < 0 ? std::max(row_u, other_rows.lower) : std::min(row_u, other_rows.upper);
    if (u < other_rows.lower || u > other_rows.upper) return {};
    return {true, u == row_u, u, u == row_u ? limits.acceleration_slope_on_bound(row, x, u) : 0};
  }
  const double u = side < 0 ? other_rows.lower : other_rows.upper;
  return {side < 0 ? u <= row_u : u >= row_u, false, u, 0};
}

bool step_from_zero_inertia(AccelerationLimits& limits, const SmoothInterval& interval, const ZeroInertia::Start& start,
                            int row, int side, VelocityProfile& profile) {
  const ProfilePoint from = profile.back();
  const double distance = expansion_step_fraction * std::min(interval.end - interval.begin, 0.05), ds = side * distance;
  const auto x_at = [&](double d) { return from.v * from.v + d * (2 * start.u + d * start.acceleration_slope); };
  const double x = x_at(ds);
  if (!(x > 0) || !(x_at(ds / 2) > 0)) return false;
  // Simpson's rule of dt = ds/√x
  const double dt = distance / 6 * (1 / from.v + 4 / std::sqrt(x_at(ds / 2)) + 1 / std::sqrt(x));
  ProfilePoint next{from.t + dt, from.s + ds, std::sqrt(x), start.u + ds * start.acceleration_slope, row};
  limits.move_to(next.s, interval.first_panel, interval.last_panel);
  const AccelerationInterval u_range = limits.bounds(x * (1 - 1e-9));
  if (u_range.is_empty()) return false;
  const double limit = side < 0 ? u_range.lower : u_range.upper;
  const int active_row = side < 0 ? u_range.lower_row : u_range.upper_row;
  if (active_row != row || std::abs(limit - next.u) > 0.05 * (std::abs(limit) + std::abs(next.u))) return false;
  profile.back().u = start.u;
  profile.back().row = row;
  profile.push_back(next);
  return true;
}

}  // namespace balance::time_optimal
