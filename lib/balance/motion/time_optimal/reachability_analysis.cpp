#include "balance/motion/time_optimal/reachability_analysis.hpp"

#include "balance/foundation/base/elementary.hpp"
#include "balance/motion/time_optimal/time_optimal_law.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace balance {
namespace {

constexpr double initial_cells = 1000;            // of a leg
constexpr double min_cells_per_interval = 24;     // of a stretch
constexpr std::size_t max_cells = 60'000;         // of a leg
constexpr double min_cell_fraction = 1e-9;        // cell, as a part of its leg
constexpr double inactive_time_tolerance = 1e-8;  // of a cell, below its limits, as a part of the duration
constexpr double cell_violation_tolerance = limit_violation_tolerance / 2;  // above it a cell is halved
constexpr double initial_squared_rate = 1e-9;   // x where nothing is known, for the order of magnitude
constexpr double squared_rate_epsilon = 1e-13;  // of x: what bounds it does so after a root and a square, too
constexpr int max_sweeps = 40;

/// A place of the grid: what is behind it belongs to one stretch, what is before it to the next.
struct PathGridPoint {
  double s = 0;
  std::size_t before = 0, after = 0;  ///< stretches
  double limit_fraction = 1;          ///< of the limits that is used
};

/// One side of a knot: the limits there, as functions of x.
class OneSidedLimits {
 public:
  OneSidedLimits(AccelerationLimits& allowed, double place, const SmoothInterval& stretch, double length)
      : allowed_(allowed) {
    allowed_.move_to(place, stretch.first_panel, stretch.last_panel);
    const bool vanishes = allowed_.drop_zero_inertia_rows();
    cap_ = allowed_.direct_velocity_bound();
    if (!vanishes || !std::isfinite(cap_.x)) return;
    const double own = allowed_.is_dropped(cap_.row) ? std::abs(allowed_.acceleration_on_bound(cap_.row, cap_.x)) : 0;
    free_ = std::max(free_acceleration_factor * cap_.x / length, std::isfinite(own) ? 2 * own : 0);
  }

  /// Where the only row's a vanishes s'' is free at one place: it is held within what is far more than it will need.
  AccelerationInterval at(double x) const {
    AccelerationInterval interval = allowed_.bounds_by_acceleration_rows(x);
    if (x > cap_.x * (1 + 1e-12)) return {INFINITY, -INFINITY, -1, -1};
    if (interval.lower > interval.upper && interval.lower - interval.upper < 1e-9 * std::abs(interval.lower))
      std::swap(interval.lower, interval.upper);  // one s'' but for round-off
    if (interval.lower == -INFINITY) interval.lower = -free_;
    if (interval.upper == INFINITY) interval.upper = free_;
    return interval;
  }
  const VelocityBound& cap() const { return cap_; }

 private:
  static constexpr double free_acceleration_factor = 10;

  AccelerationLimits& allowed_;
  VelocityBound cap_;
  double free_ = INFINITY;
};

/// The largest x up to `most` with a property that holds from rest on.
template <class Property>
double bisect(double most, const Property& holds) {
  if (holds(most)) return most;
  double low = 0, high = most;
  for (int k = 1; k < 50; ++k) {  // its order of magnitude
    const double part = std::ldexp(most, -2 * k);
    if (holds(part)) {
      low = part;
      break;
    }
    high = part;
  }
  while (high - low > 1e-15 * high && high > 1e-30 * most) {
    const double middle = (low + high) / 2;
    if (middle == low || middle == high) break;
    (holds(middle) ? low : high) = middle;
  }
  return low;
}

/// Where a concave function on [0, most] is largest.
template <class Function>
double golden_section_max(double most, const Function& f) {
  if (f(most) >= f(most * (1 - 1e-9))) return most;
  double low = 0, high = most;
  for (int part = 0; part < 90; ++part) {
    const double third = (high - low) / 3, a = low + third, b = high - third;
    (f(a) < f(b) ? low : high) = f(a) < f(b) ? a : b;
  }
  return (low + high) / 2;
}

class ReachabilitySolver {
 public:
  ReachabilitySolver(const PathModel& model, const std::vector<double>& bounds, const SegmentRange& leg,
                     const EndpointRates& rates)
      : model_(model), stated_(bounds), bounds_(bounds), leg_(leg), rates_(rates), length_(leg.end - leg.begin) {
    for (std::size_t k = 0; k < leg.smooth_intervals.size(); ++k) add_knots(k);
  }

  TimeOptimalLaw run() {
    TimeOptimalLaw law = sweep();
    for (int round = 1; round < max_sweeps && knots_.size() <= max_cells; ++round) {
      if (!law.infeasibility_reason.empty()) return law;
      if (!refine_cells(law)) break;
      law = sweep();
    }
    return tighten_limits(std::move(law));
  }

 private:
  static TimeOptimalLaw search_failed() {
    TimeOptimalLaw law;
    law.infeasibility_reason = "the search for the law lost its way";
    return law;
  }

  const SmoothInterval& interval(std::size_t k) const { return leg_.smooth_intervals[k]; }

  /// Graded towards both ends of a stretch.
  void add_knots(std::size_t k) {
    const double width = interval(k).end - interval(k).begin;
    const int cells = static_cast<int>(std::max(min_cells_per_interval, std::ceil(initial_cells * width / length_)));
    for (int i = 0; i < cells; ++i) {
      const double part = elementary::pow(elementary::sin(std::numbers::pi * i / (2 * cells)), 2);
      knots_.push_back({interval(k).begin + width * part, i == 0 && k > 0 ? k - 1 : k, k});
    }
    if (k + 1 == leg_.smooth_intervals.size()) knots_.push_back({leg_.end, k, k});
  }

  double width(std::size_t i) const { return knots_[i + 1].s - knots_[i].s; }
  OneSidedLimits limits_after(AccelerationLimits& allowed, std::size_t i) { return side(allowed, i, knots_[i].after); }
  OneSidedLimits limits_before(AccelerationLimits& allowed, std::size_t i) {
    return side(allowed, i, knots_[i].before);
  }

  /// One at a time.
  OneSidedLimits side(AccelerationLimits& allowed, std::size_t i, std::size_t k) {
    for (std::size_t r = 0; r < bounds_.size(); ++r) bounds_[r] = knots_[i].limit_fraction * stated_[r];
    return {allowed, knots_[i].s, interval(k), length_};
  }

  /// Two sweeps.
  TimeOptimalLaw sweep() {
    AccelerationLimits allowed(model_, bounds_);
    if (!backward_pass(allowed)) return search_failed();
    TimeOptimalLaw law;
    if (rates_.start * rates_.start > controllable_bound_.front() * (1 + 1e-9)) {
      law.infeasibility_reason = "the motion starts faster than it could brake within its limits";
      return law;
    }
    law.nodes.push_back({0, leg_.begin, std::min(rates_.start, std::sqrt(controllable_bound_.front())), 0, 0, -1});
    for (std::size_t i = 0; i + 1 < knots_.size(); ++i)
      if (!forward_step(allowed, i, law.nodes)) return search_failed();
    return law.nodes.back().v < rates_.end * (1 - 1e-9) ? search_failed() : law;
  }

  /// The largest x at every knot from which the end can be reached.
  bool backward_pass(AccelerationLimits& allowed) {
    controllable_bound_.assign(knots_.size(), 0);
    controllable_bound_.back() = rates_.end * rates_.end;
    for (std::size_t i = knots_.size() - 1; i-- > 0;) {
      const double h = width(i);
      double high = 0, low = 0;  // of x behind the middle of the cell, as s'' were constant on both sides of it
      {
        const OneSidedLimits end = limits_before(allowed, i + 1);
        const double most = bisect(controllable_bound_[i + 1], [&](double y) { return !end.at(y).is_empty(); });
        const auto latest = [&](double y) { return y - h * end.at(y).lower; };
        high = latest(golden_section_max(most, latest));
        low = std::min(-h * end.at(0).upper, most - h * end.at(most).upper);
      }
      const OneSidedLimits start = limits_after(allowed, i);
      const auto reaches = [&](double x) {
        const AccelerationInterval u = start.at(x);
        return !u.is_empty() && x + h * u.lower <= high && x + h * u.upper >= low;
      };
      double most = std::max({4 * controllable_bound_[i + 1], 4 * high, initial_squared_rate});
      if (std::isfinite(start.cap().x)) most = start.cap().x;
      while (!std::isfinite(start.cap().x) && reaches(most) && most < 1e60) most *= 16;
      controllable_bound_[i] = (1 - squared_rate_epsilon) * bisect(most, reaches);
      if (!std::isfinite(controllable_bound_[i]) || (!(controllable_bound_[i] > 0) && i > 0)) return false;
    }
    return true;
  }

  /// One cell, as fast as what comes allows.
  bool forward_step(AccelerationLimits& allowed, std::size_t i, std::vector<TimeLawNode>& nodes) {
    const double h = width(i), x = nodes.back().v * nodes.back().v;
    const OneSidedLimits start = limits_after(allowed, i);
    const AccelerationInterval u = start.at(x);
    const VelocityBound cap = start.cap();
    if (u.is_empty() || !std::isfinite(u.upper - u.lower)) return false;
    const OneSidedLimits end = limits_before(allowed, i + 1);
    const auto reached = [&](double y) {
      const AccelerationInterval w = end.at(y);
      return !w.is_empty() && y - h * w.upper <= x + h * u.upper;
    };
    double y = bisect(controllable_bound_[i + 1], reached);
    const auto latest = [&](double z) { return z - h * end.at(z).lower; };
    if (const double least = x + h * u.lower; latest(y) < least) {
      const double top = golden_section_max(y, latest);
      double low = top, high = y;
      for (int halving = 0; halving < 60; ++halving) {
        const double middle = (low + high) / 2;
        (latest(middle) >= least ? low : high) = middle;
      }
      y = low;
    }
    const AccelerationInterval w = end.at(y);
    if (w.is_empty() || !std::isfinite(w.upper - w.lower) || (!(y > 0) && i + 2 < knots_.size())) return false;
    add(i, x, y, u, w, cap, nodes);
    return true;
  }

  /// s'' at both ends has the mean that leads from x to y; of all pairs the one that is most even.
  void add(std::size_t i, double x, double y, const AccelerationInterval& u, const AccelerationInterval& w,
           const VelocityBound& cap, std::vector<TimeLawNode>& nodes) const {
    const double h = width(i), sum = (y - x) / h;
    double first = std::clamp(sum / 2, u.lower, u.upper);
    const double second = std::clamp(sum - first, w.lower, w.upper);
    first = std::clamp(sum - second, u.lower, u.upper);
    TimeLawNode& from = nodes.back();
    from.u_after = first;
    if (nodes.size() == 1) from.u_before = first;
    const double near = 1e-6 * (u.upper - u.lower);
    from.row_after = u.upper - first <= near ? u.upper_row : first - u.lower <= near ? u.lower_row : -1;
    if (x > cap.x * (1 - 1e-6)) from.row_after = cap.row;
    const double v = std::sqrt(y);
    nodes.push_back({from.t + duration(h, from.v, v, (second - first) / h), knots_[i + 1].s, v, second, second, -1});
  }

  /// Of a cell with s'' = u + k s, exactly: tanh(ωt/2) = ωh/(v₀ + v₁) with ω² = k, the tangent with ω² = −k.
  static double duration(double h, double v0, double v1, double k) {
    const double omega = std::sqrt(std::abs(k)), z = omega * h / (v0 + v1);
    if (z < 1e-4) return 2 * h / (v0 + v1) * (1 + (k > 0 ? z * z : -z * z) / 3);
    return 2 / omega * (k > 0 ? elementary::atanh(std::min(z, 1 - 1e-15)) : elementary::atan(z));
  }

  /// Whether limits are not kept between a cell's ends, or nowhere in it is one reached, which costs time.
  bool is_coarse(AccelerationLimits& allowed, const TimeOptimalLaw& law, std::size_t i) const {
    const TimeLawNode &from = law.nodes[i], &to = law.nodes[i + 1];
    const double load = find_max_limit_ratio_between(model_, stated_, allowed, from, to);
    return load > 1 + cell_violation_tolerance ||
           (1 - load) * (to.t - from.t) > inactive_time_tolerance * law.duration();
  }

  /// Halves the coarse cells and their neighbours. @return whether there are any
  bool refine_cells(const TimeOptimalLaw& law) {
    AccelerationLimits allowed(model_, stated_);
    std::vector<char> halved(knots_.size() - 1, 0);
    for (std::size_t i = 0; i + 1 < knots_.size(); ++i)
      if (is_coarse(allowed, law, i))
        for (std::size_t j = i > 0 ? i - 1 : 0; j <= std::min(i + 1, halved.size() - 1); ++j) halved[j] = 1;
    std::vector<PathGridPoint> knots;
    bool any = false;
    for (std::size_t i = 0; i < knots_.size(); ++i) {
      knots.push_back(knots_[i]);
      if (i == halved.size() || !halved[i] || width(i) < 2 * min_cell_fraction * length_) continue;
      any = true;
      knots.push_back({knots_[i].s + width(i) / 2, knots_[i].after, knots_[i].after});
    }
    knots_ = std::move(knots);
    return any;
  }

  /// Where limits are exceeded between knots they are narrowed at them.
  TimeOptimalLaw tighten_limits(TimeOptimalLaw law) {
    AccelerationLimits allowed(model_, stated_);
    for (int round = 0; round < max_sweeps && law.infeasibility_reason.empty(); ++round) {
      bool any = false;
      for (std::size_t i = 0; i + 1 < knots_.size(); ++i) {
        const double load = find_max_limit_ratio_between(model_, stated_, allowed, law.nodes[i], law.nodes[i + 1]);
        if (load < 1 + 0.9 * limit_violation_tolerance) continue;
        any = true;
        knots_[i].limit_fraction *= (1 + limit_violation_tolerance / 4) / load;
        knots_[i + 1].limit_fraction *= (1 + limit_violation_tolerance / 4) / load;
      }
      if (!any) return law;
      law = sweep();
    }
    return law;
  }

  const PathModel& model_;
  const std::vector<double>& stated_;
  std::vector<double> bounds_;  ///< at the knot that is looked at
  const SegmentRange& leg_;
  EndpointRates rates_;
  double length_;
  std::vector<PathGridPoint> knots_;
  std::vector<double> controllable_bound_;  ///< x at the knots from which the end can be reached
};

}  // namespace

TimeOptimalLaw solve_by_reachability(const PathModel& model, const std::vector<double>& bounds, const SegmentRange& leg,
                                     const EndpointRates& rates) {
  return ReachabilitySolver(model, bounds, leg, rates).run();
}

}  // namespace balance
