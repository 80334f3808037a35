#include "balance/timing/swept.hpp"

#include "balance/base/elementary.hpp"
#include "balance/timing/kept_limits.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace balance {
namespace {

constexpr double first_cells = 1000;        // of a leg
constexpr double least_cells = 24;          // of a stretch
constexpr std::size_t most_cells = 60'000;  // of a leg
constexpr double narrowest = 1e-9;          // cell, as a part of its leg
constexpr double idle_time = 1e-8;          // of a cell, below its limits, as a part of the duration
constexpr double kept_in_cells = kept / 2;  // above it a cell is halved
constexpr double least_rate = 1e-9;         // x where nothing is known, for the order of magnitude
constexpr double of_round_off = 1e-13;      // of x: what bounds it does so after a root and a square, too
constexpr int most_sweeps = 40;

/// A place of the grid: what is behind it belongs to one stretch, what is before it to the next.
struct Knot {
  double s = 0;
  std::size_t before = 0, after = 0;  ///< stretches
  double part = 1;                    ///< of the limits that is used
};

/// One side of a knot: the limits there, as functions of x.
class KnotSide {
 public:
  KnotSide(Allowed& allowed, double place, const Smooth& stretch, double length) : allowed_(allowed) {
    allowed_.go(place, stretch.first_panel, stretch.last_panel);
    const bool vanishes = allowed_.drop_inertia();
    cap_ = allowed_.cap();
    if (!vanishes || !std::isfinite(cap_.x)) return;
    const double own = allowed_.has_dropped(cap_.row) ? std::abs(allowed_.along(cap_.row, cap_.x)) : 0;
    free_ = std::max(far_beyond * cap_.x / length, std::isfinite(own) ? 2 * own : 0);
  }

  /// Where the only row's a vanishes s'' is free at one place: it is held within what is far more than it will need.
  Interval at(double x) const {
    Interval interval = allowed_.by_inertia(x);
    if (x > cap_.x * (1 + 1e-12)) return {INFINITY, -INFINITY, -1, -1};
    if (interval.low > interval.high && interval.low - interval.high < 1e-9 * std::abs(interval.low))
      std::swap(interval.low, interval.high);  // one s'' but for round-off
    if (interval.low == -INFINITY) interval.low = -free_;
    if (interval.high == INFINITY) interval.high = free_;
    return interval;
  }
  const Ceiling& cap() const { return cap_; }

 private:
  static constexpr double far_beyond = 10;

  Allowed& allowed_;
  Ceiling cap_;
  double free_ = INFINITY;
};

/// The largest x up to `most` with a property that holds from rest on.
template <class Property>
double largest_with(double most, const Property& holds) {
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
double summit(double most, const Function& f) {
  if (f(most) >= f(most * (1 - 1e-9))) return most;
  double low = 0, high = most;
  for (int part = 0; part < 90; ++part) {
    const double third = (high - low) / 3, a = low + third, b = high - third;
    (f(a) < f(b) ? low : high) = f(a) < f(b) ? a : b;
  }
  return (low + high) / 2;
}

class Sweep {
 public:
  Sweep(const PathModel& model, const std::vector<double>& bounds, const LegOfPath& leg, const EndRates& rates)
      : model_(model), stated_(bounds), bounds_(bounds), leg_(leg), rates_(rates), length_(leg.end - leg.begin) {
    for (std::size_t k = 0; k < leg.stretches.size(); ++k) add_knots(k);
  }

  FastestLaw run() {
    FastestLaw law = once();
    for (int round = 1; round < most_sweeps && knots_.size() <= most_cells; ++round) {
      if (!law.refusal.empty()) return law;
      if (!halve_coarse(law)) break;
      law = once();
    }
    return tightened(std::move(law));
  }

 private:
  static FastestLaw lost() {
    FastestLaw law;
    law.refusal = "the search for the law lost its way";
    return law;
  }

  const Smooth& stretch(std::size_t k) const { return leg_.stretches[k]; }

  /// Graded towards both ends of a stretch.
  void add_knots(std::size_t k) {
    const double width = stretch(k).end - stretch(k).begin;
    const int cells = static_cast<int>(std::max(least_cells, std::ceil(first_cells * width / length_)));
    for (int i = 0; i < cells; ++i) {
      const double part = elementary::pow(elementary::sin(std::numbers::pi * i / (2 * cells)), 2);
      knots_.push_back({stretch(k).begin + width * part, i == 0 && k > 0 ? k - 1 : k, k});
    }
    if (k + 1 == leg_.stretches.size()) knots_.push_back({leg_.end, k, k});
  }

  double width(std::size_t i) const { return knots_[i + 1].s - knots_[i].s; }
  KnotSide behind(Allowed& allowed, std::size_t i) { return side(allowed, i, knots_[i].after); }
  KnotSide ahead(Allowed& allowed, std::size_t i) { return side(allowed, i, knots_[i].before); }

  /// One at a time.
  KnotSide side(Allowed& allowed, std::size_t i, std::size_t k) {
    for (std::size_t r = 0; r < bounds_.size(); ++r) bounds_[r] = knots_[i].part * stated_[r];
    return {allowed, knots_[i].s, stretch(k), length_};
  }

  /// Two sweeps.
  FastestLaw once() {
    Allowed allowed(model_, bounds_);
    if (!backwards(allowed)) return lost();
    FastestLaw law;
    if (rates_.start * rates_.start > most_.front() * (1 + 1e-9)) {
      law.refusal = "the motion starts faster than it could brake within its limits";
      return law;
    }
    law.nodes.push_back({0, leg_.begin, std::min(rates_.start, std::sqrt(most_.front())), 0, 0, -1});
    for (std::size_t i = 0; i + 1 < knots_.size(); ++i)
      if (!forwards(allowed, i, law.nodes)) return lost();
    return law.nodes.back().v < rates_.end * (1 - 1e-9) ? lost() : law;
  }

  /// The largest x at every knot from which the end can be reached.
  bool backwards(Allowed& allowed) {
    most_.assign(knots_.size(), 0);
    most_.back() = rates_.end * rates_.end;
    for (std::size_t i = knots_.size() - 1; i-- > 0;) {
      const double h = width(i);
      double high = 0, low = 0;  // of x behind the middle of the cell, as s'' were constant on both sides of it
      {
        const KnotSide end = ahead(allowed, i + 1);
        const double most = largest_with(most_[i + 1], [&](double y) { return !end.at(y).empty(); });
        const auto latest = [&](double y) { return y - h * end.at(y).low; };
        high = latest(summit(most, latest));
        low = std::min(-h * end.at(0).high, most - h * end.at(most).high);
      }
      const KnotSide start = behind(allowed, i);
      const auto reaches = [&](double x) {
        const Interval u = start.at(x);
        return !u.empty() && x + h * u.low <= high && x + h * u.high >= low;
      };
      double most = std::max({4 * most_[i + 1], 4 * high, least_rate});
      if (std::isfinite(start.cap().x)) most = start.cap().x;
      while (!std::isfinite(start.cap().x) && reaches(most) && most < 1e60) most *= 16;
      most_[i] = (1 - of_round_off) * largest_with(most, reaches);
      if (!std::isfinite(most_[i]) || (!(most_[i] > 0) && i > 0)) return false;
    }
    return true;
  }

  /// One cell, as fast as what comes allows.
  bool forwards(Allowed& allowed, std::size_t i, std::vector<TimedNode>& nodes) {
    const double h = width(i), x = nodes.back().v * nodes.back().v;
    const KnotSide start = behind(allowed, i);
    const Interval u = start.at(x);
    const Ceiling cap = start.cap();
    if (u.empty() || !std::isfinite(u.high - u.low)) return false;
    const KnotSide end = ahead(allowed, i + 1);
    const auto reached = [&](double y) {
      const Interval w = end.at(y);
      return !w.empty() && y - h * w.high <= x + h * u.high;
    };
    double y = largest_with(most_[i + 1], reached);
    const auto latest = [&](double z) { return z - h * end.at(z).low; };
    if (const double least = x + h * u.low; latest(y) < least) {
      const double top = summit(y, latest);
      double low = top, high = y;
      for (int halving = 0; halving < 60; ++halving) {
        const double middle = (low + high) / 2;
        (latest(middle) >= least ? low : high) = middle;
      }
      y = low;
    }
    const Interval w = end.at(y);
    if (w.empty() || !std::isfinite(w.high - w.low) || (!(y > 0) && i + 2 < knots_.size())) return false;
    add(i, x, y, u, w, cap, nodes);
    return true;
  }

  /// s'' at both ends has the mean that leads from x to y; of all pairs the one that is most even.
  void add(std::size_t i, double x, double y, const Interval& u, const Interval& w, const Ceiling& cap,
           std::vector<TimedNode>& nodes) const {
    const double h = width(i), sum = (y - x) / h;
    double first = std::clamp(sum / 2, u.low, u.high);
    const double second = std::clamp(sum - first, w.low, w.high);
    first = std::clamp(sum - second, u.low, u.high);
    TimedNode& from = nodes.back();
    from.u_after = first;
    if (nodes.size() == 1) from.u_before = first;
    const double near = 1e-6 * (u.high - u.low);
    from.row_after = u.high - first <= near ? u.high_row : first - u.low <= near ? u.low_row : -1;
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
  bool is_coarse(Allowed& allowed, const FastestLaw& law, std::size_t i) const {
    const TimedNode &from = law.nodes[i], &to = law.nodes[i + 1];
    const double load = load_between(model_, stated_, allowed, from, to);
    return load > 1 + kept_in_cells || (1 - load) * (to.t - from.t) > idle_time * law.duration();
  }

  /// Halves the coarse cells and their neighbours. @return whether there are any
  bool halve_coarse(const FastestLaw& law) {
    Allowed allowed(model_, stated_);
    std::vector<char> halved(knots_.size() - 1, 0);
    for (std::size_t i = 0; i + 1 < knots_.size(); ++i)
      if (is_coarse(allowed, law, i))
        for (std::size_t j = i > 0 ? i - 1 : 0; j <= std::min(i + 1, halved.size() - 1); ++j) halved[j] = 1;
    std::vector<Knot> knots;
    bool any = false;
    for (std::size_t i = 0; i < knots_.size(); ++i) {
      knots.push_back(knots_[i]);
      if (i == halved.size() || !halved[i] || width(i) < 2 * narrowest * length_) continue;
      any = true;
      knots.push_back({knots_[i].s + width(i) / 2, knots_[i].after, knots_[i].after});
    }
    knots_ = std::move(knots);
    return any;
  }

  /// Where limits are exceeded between knots they are narrowed at them.
  FastestLaw tightened(FastestLaw law) {
    Allowed allowed(model_, stated_);
    for (int round = 0; round < most_sweeps && law.refusal.empty(); ++round) {
      bool any = false;
      for (std::size_t i = 0; i + 1 < knots_.size(); ++i) {
        const double load = load_between(model_, stated_, allowed, law.nodes[i], law.nodes[i + 1]);
        if (load < 1 + 0.9 * kept) continue;
        any = true;
        knots_[i].part *= (1 + kept / 4) / load;
        knots_[i + 1].part *= (1 + kept / 4) / load;
      }
      if (!any) return law;
      law = once();
    }
    return law;
  }

  const PathModel& model_;
  const std::vector<double>& stated_;
  std::vector<double> bounds_;  ///< at the knot that is looked at
  const LegOfPath& leg_;
  EndRates rates_;
  double length_;
  std::vector<Knot> knots_;
  std::vector<double> most_;  ///< x at the knots from which the end can be reached
};

}  // namespace

FastestLaw sweep_leg(const PathModel& model, const std::vector<double>& bounds, const LegOfPath& leg,
                     const EndRates& rates) {
  return Sweep(model, bounds, leg, rates).run();
}

}  // namespace balance
