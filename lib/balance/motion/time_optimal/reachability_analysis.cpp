#include "balance/motion/time_optimal/reachability_analysis.hpp"

#include "balance/foundation/base/elementary.hpp"
#include "balance/motion/time_optimal/time_optimal_law.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace balance::time_optimal {
namespace {

constexpr double initial_cells = 1000;            // per leg
constexpr double min_cells_per_interval = 24;     // per smooth interval
constexpr std::size_t max_cells = 60'000;         // per leg
constexpr double min_cell_fraction = 1e-9;        // of a cell, as a fraction of its leg
constexpr double inactive_time_tolerance = 1e-8;  // time lost in a cell below the limits, as a fraction of the duration
constexpr double cell_violation_tolerance = limit_violation_tolerance / 2;  // cells with a larger violation are halved
constexpr double initial_squared_rate = 1e-9;   // initial x if nothing is known, for its order of magnitude
constexpr double squared_rate_epsilon = 1e-13;  // of x: keeps its bounds valid after a square root and a square
constexpr int max_sweeps = 40;

/// A grid point. The path before it belongs to one smooth interval, the path after it to the next.
struct PathGridPoint {
  double s = 0;
  std::size_t before = 0, after = 0;  ///< indices of smooth intervals
  double limit_fraction = 1;          ///< fraction of the limits that is used
};

/// The limits on one side of a grid point, as functions of x.
class OneSidedLimits {
 public:
  OneSidedLimits(AccelerationLimits& limits, double s, const SmoothInterval& interval, double length)
      : limits_(limits) {
    limits_.move_to(s, interval.first_panel, interval.last_panel);
    const bool has_dropped_rows = limits_.drop_zero_inertia_rows();
    velocity_bound_ = limits_.direct_velocity_bound();
    if (!has_dropped_rows || !std::isfinite(velocity_bound_.x)) return;
    const double row_acceleration =
        limits_.is_dropped(velocity_bound_.row)
            ? std::abs(limits_.acceleration_on_bound(velocity_bound_.row, velocity_bound_.x))
            : 0;
    free_acceleration_ = std::max(free_acceleration_factor * velocity_bound_.x / length,
                                  std::isfinite(row_acceleration) ? 2 * row_acceleration : 0);
  }

  /// If the only row's a vanishes, s'' is free at one point. It is then held within bounds far beyond what it needs.
  AccelerationInterval at(double x) const {
    AccelerationInterval interval = limits_.bounds_by_acceleration_rows(x);
    if (x > velocity_bound_.x * (1 + 1e-12)) return {INFINITY, -INFINITY, -1, -1};
    if (interval.lower > interval.upper && interval.lower - interval.upper < 1e-9 * std::abs(interval.lower))
      std::swap(interval.lower, interval.upper);  // a single s'' up to round-off
    if (interval.lower == -INFINITY) interval.lower = -free_acceleration_;
    if (interval.upper == INFINITY) interval.upper = free_acceleration_;
    return interval;
  }
  const VelocityBound& velocity_bound() const { return velocity_bound_; }

 private:
  static constexpr double free_acceleration_factor = 10;

  AccelerationLimits& limits_;
  VelocityBound velocity_bound_;
  double free_acceleration_ = INFINITY;
};

/// The largest x up to `most` with a property that holds in an interval starting at rest.
template <class Property>
double bisect(double max_x, const Property& holds) {
  if (holds(max_x)) return max_x;
  double low = 0, high = max_x;
  for (int k = 1; k < 50; ++k) {  // find the order of magnitude
    const double candidate = std::ldexp(max_x, -2 * k);
    if (holds(candidate)) {
      low = candidate;
      break;
    }
    high = candidate;
  }
  while (high - low > 1e-15 * high && high > 1e-30 * max_x) {
    const double middle = (low + high) / 2;
    if (middle == low || middle == high) break;
    (holds(middle) ? low : high) = middle;
  }
  return low;
}

/// Where a concave function on [0, most] attains its maximum.
template <class Function>
double ternary_search_max(double max_x, const Function& f) {
  if (f(max_x) >= f(max_x * (1 - 1e-9))) return max_x;
  double low = 0, high = max_x;
  for (int iteration = 0; iteration < 90; ++iteration) {
    const double third = (high - low) / 3, a = low + third, b = high - third;
    (f(a) < f(b) ? low : high) = f(a) < f(b) ? a : b;
  }
  return (low + high) / 2;
}

class ReachabilitySolver {
 public:
  ReachabilitySolver(const PathModel& model, const std::vector<double>& bounds, const SegmentRange& leg,
                     const EndpointRates& rates)
      : model_(model),
        nominal_bounds_(bounds),
        bounds_(bounds),
        leg_(leg),
        rates_(rates),
        length_(leg.end - leg.begin) {
    for (std::size_t k = 0; k < leg.smooth_intervals.size(); ++k) add_grid_points(k);
  }

  TimeOptimalLaw run() {
    TimeOptimalLaw law = sweep();
    for (int sweep_count = 1; sweep_count < max_sweeps && grid_.size() <= max_cells; ++sweep_count) {
      if (!law.infeasibility_reason.empty()) return law;
      if (!refine_cells(law)) break;
      law = sweep();
    }
    return tighten_limits(std::move(law));
  }

 private:
  static TimeOptimalLaw search_failed() {
    TimeOptimalLaw law;
    law.infeasibility_reason = "the search for the law failed";
    return law;
  }

  const SmoothInterval& interval(std::size_t k) const { return leg_.smooth_intervals[k]; }

  /// Adds the grid points of an interval, graded towards both ends.
  void add_grid_points(std::size_t k) {
    const double width = interval(k).end - interval(k).begin;
    const int cells = static_cast<int>(std::max(min_cells_per_interval, std::ceil(initial_cells * width / length_)));
    for (int i = 0; i < cells; ++i) {
      const double fraction = elementary::pow(elementary::sin(std::numbers::pi * i / (2 * cells)), 2);
      grid_.push_back({interval(k).begin + width * fraction, i == 0 && k > 0 ? k - 1 : k, k});
    }
    if (k + 1 == leg_.smooth_intervals.size()) grid_.push_back({leg_.end, k, k});
  }

  double width(std::size_t i) const { return grid_[i + 1].s - grid_[i].s; }
  OneSidedLimits limits_after(AccelerationLimits& limits, std::size_t i) {
    return limits_at(limits, i, grid_[i].after);
  }
  OneSidedLimits limits_before(AccelerationLimits& limits, std::size_t i) {
    return limits_at(limits, i, grid_[i].before);
  }

  /// Use one at a time: all share `bounds_`.
  OneSidedLimits limits_at(AccelerationLimits& limits, std::size_t i, std::size_t k) {
    for (std::size_t r = 0; r < bounds_.size(); ++r) bounds_[r] = grid_[i].limit_fraction * nominal_bounds_[r];
    return {limits, grid_[i].s, interval(k), length_};
  }

  /// Backward and forward pass.
  TimeOptimalLaw sweep() {
    AccelerationLimits limits(model_, bounds_);
    if (!backward_pass(limits)) return search_failed();
    TimeOptimalLaw law;
    if (rates_.start * rates_.start > controllable_bound_.front() * (1 + 1e-9)) {
      law.infeasibility_reason = "the motion starts too fast to brake within its limits";
      return law;
    }
    law.nodes.push_back({0, leg_.begin, std::min(rates_.start, std::sqrt(controllable_bound_.front())), 0, 0, -1});
    for (std::size_t i = 0; i + 1 < grid_.size(); ++i)
      if (!forward_step(limits, i, law.nodes)) return search_failed();
    return law.nodes.back().v < rates_.end * (1 - 1e-9) ? search_failed() : law;
  }

  /// Computes the largest x at every grid point from which the end can be reached.
  bool backward_pass(AccelerationLimits& limits) {
    controllable_bound_.assign(grid_.size(), 0);
    controllable_bound_.back() = rates_.end * rates_.end;
    for (std::size_t i = grid_.size() - 1; i-- > 0;) {
      const double h = width(i);
      double high = 0, low = 0;  // bounds of x_(i+1) − h w, the value of x in the middle of the cell
      {
        const OneSidedLimits end = limits_before(limits, i + 1);
        const double max_x = bisect(controllable_bound_[i + 1], [&](double y) { return !end.at(y).is_empty(); });
        const auto max_middle_x = [&](double y) { return y - h * end.at(y).lower; };
        high = max_middle_x(ternary_search_max(max_x, max_middle_x));
        low = std::min(-h * end.at(0).upper, max_x - h * end.at(max_x).upper);
      }
      const OneSidedLimits start = limits_after(limits, i);
      const auto can_reach_end = [&](double x) {
        const AccelerationInterval u = start.at(x);
        return !u.is_empty() && x + h * u.lower <= high && x + h * u.upper >= low;
      };
      double max_x = std::max({4 * controllable_bound_[i + 1], 4 * high, initial_squared_rate});
      if (std::isfinite(start.velocity_bound().x)) max_x = start.velocity_bound().x;
      while (!std::isfinite(start.velocity_bound().x) && can_reach_end(max_x) && max_x < 1e60) max_x *= 16;
      controllable_bound_[i] = (1 - squared_rate_epsilon) * bisect(max_x, can_reach_end);
      if (!std::isfinite(controllable_bound_[i]) || (!(controllable_bound_[i] > 0) && i > 0)) return false;
    }
    return true;
  }

  /// Traverses one cell as fast as the rest of the leg allows.
  bool forward_step(AccelerationLimits& limits, std::size_t i, std::vector<TimeLawNode>& nodes) {
    const double h = width(i), x = nodes.back().v * nodes.back().v;
    const OneSidedLimits start = limits_after(limits, i);
    const AccelerationInterval u = start.at(x);
    const VelocityBound velocity_bound = start.velocity_bound();
    if (u.is_empty() || !std::isfinite(u.upper - u.lower)) return false;
    const OneSidedLimits end = limits_before(limits, i + 1);
    const auto is_reachable = [&](double y) {
      const AccelerationInterval w = end.at(y);
      return !w.is_empty() && y - h * w.upper <= x + h * u.upper;
    };
    double y = bisect(controllable_bound_[i + 1], is_reachable);
    const auto max_middle_x = [&](double z) { return z - h * end.at(z).lower; };
    if (const double min_middle_x = x + h * u.lower; max_middle_x(y) < min_middle_x) {
      const double peak_y = ternary_search_max(y, max_middle_x);
      double low = peak_y, high = y;
      for (int halving = 0; halving < 60; ++halving) {
        const double middle = (low + high) / 2;
        (max_middle_x(middle) >= min_middle_x ? low : high) = middle;
      }
      y = low;
    }
    const AccelerationInterval w = end.at(y);
    if (w.is_empty() || !std::isfinite(w.upper - w.lower) || (!(y > 0) && i + 2 < grid_.size())) return false;
    add_node(i, x, y, u, w, velocity_bound, nodes);
    return true;
  }

  /// Chooses s'' at both ends with the mean that leads from x to y; of all such pairs, the most uniform one.
  void add_node(std::size_t i, double x, double y, const AccelerationInterval& u, const AccelerationInterval& w,
                const VelocityBound& velocity_bound, std::vector<TimeLawNode>& nodes) const {
    const double h = width(i), sum = (y - x) / h;
    double first = std::clamp(sum / 2, u.lower, u.upper);
    const double second = std::clamp(sum - first, w.lower, w.upper);
    first = std::clamp(sum - second, u.lower, u.upper);
    TimeLawNode& from = nodes.back();
    from.u_after = first;
    if (nodes.size() == 1) from.u_before = first;
    const double near = 1e-6 * (u.upper - u.lower);
    from.row_after = u.upper - first <= near ? u.upper_row : first - u.lower <= near ? u.lower_row : -1;
    if (x > velocity_bound.x * (1 - 1e-6)) from.row_after = velocity_bound.row;
    const double v = std::sqrt(y);
    nodes.push_back({from.t + duration(h, from.v, v, (second - first) / h), grid_[i + 1].s, v, second, second, -1});
  }

  /// Exact duration of a cell with s'' = u + k s: tanh(ωt/2) = ωh/(v₀ + v₁) with ω² = k, or the tangent with ω² = −k.
  static double duration(double h, double v0, double v1, double k) {
    const double omega = std::sqrt(std::abs(k)), z = omega * h / (v0 + v1);
    if (z < 1e-4) return 2 * h / (v0 + v1) * (1 + (k > 0 ? z * z : -z * z) / 3);
    return 2 / omega * (k > 0 ? elementary::atanh(std::min(z, 1 - 1e-15)) : elementary::atan(z));
  }

  /// Whether limits are violated between the ends of a cell, or none is active in it, which costs time.
  bool is_coarse(AccelerationLimits& limits, const TimeOptimalLaw& law, std::size_t i) const {
    const TimeLawNode &from = law.nodes[i], &to = law.nodes[i + 1];
    const double limit_ratio = find_max_limit_ratio_between(model_, nominal_bounds_, limits, from, to);
    return limit_ratio > 1 + cell_violation_tolerance ||
           (1 - limit_ratio) * (to.t - from.t) > inactive_time_tolerance * law.duration();
  }

  /// Halves coarse cells and their neighbours. @return whether there are any
  bool refine_cells(const TimeOptimalLaw& law) {
    AccelerationLimits limits(model_, nominal_bounds_);
    std::vector<char> is_halved(grid_.size() - 1, 0);
    for (std::size_t i = 0; i + 1 < grid_.size(); ++i)
      if (is_coarse(limits, law, i))
        for (std::size_t j = i > 0 ? i - 1 : 0; j <= std::min(i + 1, is_halved.size() - 1); ++j) is_halved[j] = 1;
    std::vector<PathGridPoint> refined_grid;
    bool is_refined = false;
    for (std::size_t i = 0; i < grid_.size(); ++i) {
      refined_grid.push_back(grid_[i]);
      if (i == is_halved.size() || !is_halved[i] || width(i) < 2 * min_cell_fraction * length_) continue;
      is_refined = true;
      refined_grid.push_back({grid_[i].s + width(i) / 2, grid_[i].after, grid_[i].after});
    }
    grid_ = std::move(refined_grid);
    return is_refined;
  }

  /// Tightens the limits at grid points between which they are violated.
  TimeOptimalLaw tighten_limits(TimeOptimalLaw law) {
    AccelerationLimits limits(model_, nominal_bounds_);
    for (int sweep_count = 0; sweep_count < max_sweeps && law.infeasibility_reason.empty(); ++sweep_count) {
      bool is_violated = false;
      for (std::size_t i = 0; i + 1 < grid_.size(); ++i) {
        const double limit_ratio =
            find_max_limit_ratio_between(model_, nominal_bounds_, limits, law.nodes[i], law.nodes[i + 1]);
        if (limit_ratio < 1 + 0.9 * limit_violation_tolerance) continue;
        is_violated = true;
        grid_[i].limit_fraction *= (1 + limit_violation_tolerance / 4) / limit_ratio;
        grid_[i + 1].limit_fraction *= (1 + limit_violation_tolerance / 4) / limit_ratio;
      }
      if (!is_violated) return law;
      law = sweep();
    }
    return law;
  }

  const PathModel& model_;
  const std::vector<double>& nominal_bounds_;
  std::vector<double> bounds_;  ///< at the current grid point
  const SegmentRange& leg_;
  EndpointRates rates_;
  double length_;
  std::vector<PathGridPoint> grid_;
  std::vector<double> controllable_bound_;  ///< largest x at the grid points from which the end can be reached
};

}  // namespace

TimeOptimalLaw solve_by_reachability(const PathModel& model, const std::vector<double>& bounds, const SegmentRange& leg,
                                     const EndpointRates& rates) {
  return ReachabilitySolver(model, bounds, leg, rates).run();
}

}  // namespace balance::time_optimal
