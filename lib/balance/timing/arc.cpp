#include "balance/timing/arc.hpp"

#include "balance/base/elementary.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace balance {
namespace {

constexpr double place_tolerance = 1e-12;  // of a step, as a part of the path
constexpr double rate_tolerance = 1e-11;   // of a step, relative
constexpr double bend_tolerance = 1e-7;    // of the quintic's s'' between nodes, relative
constexpr double kink = 1e-6;              // steps below this part of the arc's longest one step over kinks of s''
constexpr double shortest = 1e-7;          // and below this part cannot go on: round-off would show in s''
constexpr double on_cap = 1e-13;           // of its x
constexpr double slope_step = 1e-5;        // of a stretch: for the slope of the ceiling
constexpr double near_target = 0.05;       // of a step: what it falls short of its target by is added to it
constexpr int most_steps = 20000;

struct PathState {
  double s = 0, v = 0;
};

/// Dormand and Prince, 1980: fifth order, the fourth embedded.
constexpr std::array<std::array<double, 6>, 6> stages{
    {{1.0 / 5},
     {3.0 / 40, 9.0 / 40},
     {44.0 / 45, -56.0 / 15, 32.0 / 9},
     {19372.0 / 6561, -25360.0 / 2187, 64448.0 / 6561, -212.0 / 729},
     {9017.0 / 3168, -355.0 / 33, 46732.0 / 5247, 49.0 / 176, -5103.0 / 18656},
     {35.0 / 384, 0, 500.0 / 1113, 125.0 / 192, -2187.0 / 6784, 11.0 / 84}}};
constexpr std::array<double, 7> differences{71.0 / 57600,      0,          -71.0 / 16695, 71.0 / 1920,
                                            -17253.0 / 339200, 22.0 / 525, -1.0 / 40};

class Follower {
 public:
  Follower(Allowed& allowed, const Smooth& stretch, Edge edge, double until, const Watcher& watcher, double under,
           Arc& arc)
      : allowed_(allowed),
        stretch_(stretch),
        edge_(edge),
        sign_(edge == Edge::brake ? -1 : 1),
        until_(until),
        watcher_(watcher),
        under_(under),
        arc_(arc) {}

  ArcEnd run() {
    if (sign_ * (until_ - arc_.back().s) <= 0) return ArcEnd::arrived;
    if (edge_ != Edge::slide && excess(arc_.back()) > 1e-9) return ArcEnd::blocked;
    ArcNode first = arc_.back();
    if (!look(first)) return end_;
    if (edge_ == Edge::speed_up && under_ == 0 && climbs_along_cap(first)) return ArcEnd::capped;
    if (arc_.size() > 1)
      arc_.push_back(first);  // the same place with s'' on this side of it
    else
      arc_.back() = first;
    if (edge_ != Edge::slide && arc_.back().v == 0 && !(sign_ * arc_.back().u > 0)) return ArcEnd::stuck;
    double h = first_step();
    longest_ = h;
    for (int step = 0; step < most_steps; ++step) {
      ArcNode next;
      end_ = ArcEnd::arrived;
      if (h < shortest * longest_ || allowed_.exhausted()) return ArcEnd::blocked;
      h = std::min(h, time_left());
      bool last = false;
      bool right = try_step(h, next);
      if (right && sign_ * (next.s - until_) > -near_target * std::abs(next.s - arc_.back().s))
        last = right = land(h, next);
      if (!right) {
        h /= 4;
        if (h < shortest * longest_) return end_ == ArcEnd::arrived ? ArcEnd::blocked : end_;
        continue;
      }
      if (error_ > 1 && h > kink * longest_) {
        h *= std::clamp(0.9 * elementary::pow(error_, -0.2), 0.15, 0.9);
        continue;
      }
      const bool capped = edge_ != Edge::slide && excess(next) > on_cap;
      if (capped && !land_on_cap(h, next)) {
        h /= 4;
        if (h < shortest * longest_) return ArcEnd::blocked;
        continue;
      }
      arc_.push_back(next);
      if (watcher_ && watcher_(arc_[arc_.size() - 2], arc_.back())) return ArcEnd::told;
      if (capped) return ArcEnd::capped;
      if (last) return ArcEnd::arrived;
      longest_ = std::max(longest_, h);
      h *= std::clamp(0.9 * elementary::pow(std::max(error_, 1e-12), -0.2), 0.3, 4.0);
    }
    return ArcEnd::blocked;
  }

 private:
  /// To the target at the present s'': longer steps would ask for places beyond it.
  double time_left() const {
    const ArcNode& now = arc_.back();
    const double way = std::abs(until_ - now.s), gain = sign_ * now.u;
    const double square = now.v * now.v + 2 * gain * way;
    return square > 0 ? 2 * way / (now.v + std::sqrt(square)) : now.v > 0 ? 2 * way / now.v : INFINITY;
  }

  /// s'' and its row at a node. @return false: there is none
  bool look(ArcNode& node) {
    allowed_.go(node.s, stretch_.first_panel, stretch_.last_panel);
    const double x = node.v * node.v, beyond = 0.05 * (stretch_.end - stretch_.begin);
    if (!(node.s > stretch_.begin - beyond && node.s < stretch_.end + beyond) || !std::isfinite(x))
      return fails(ArcEnd::blocked);
    if (edge_ == Edge::slide) return look_along_cap(node);
    const Interval interval = allowed_.by_inertia(x);
    if (interval.empty()) return fails(ArcEnd::blocked);
    node.u = edge_ == Edge::brake ? interval.low : interval.high;
    node.row = edge_ == Edge::brake ? interval.low_row : interval.high_row;
    if (!std::isfinite(node.u)) return fails(ArcEnd::unlimited);
    width_ = std::isfinite(interval.high - interval.low) ? interval.high - interval.low : std::abs(node.u);
    return true;
  }

  bool look_along_cap(ArcNode& node) {
    if (under_ > 0) return look_under_ceiling(node);
    const Ceiling cap = allowed_.cap();
    if (cap.row < 0 || !(cap.x > 0)) return fails(ArcEnd::blocked);
    node.v = std::sqrt(cap.x);
    node.u = allowed_.along(cap.row, cap.x);
    node.row = cap.row;
    const Interval interval = allowed_.by_inertia(cap.x);
    if (interval.empty()) return fails(ArcEnd::blocked);
    width_ = std::isfinite(interval.high - interval.low) ? interval.high - interval.low : std::abs(node.u);
    const double slack = 1e-9 * std::abs(node.u) + 1e-12 * width_;
    if (node.u > interval.high + slack) return fails(ArcEnd::left);
    if (node.u < interval.low - slack) return fails(ArcEnd::blocked);
    return true;
  }

  bool fails(ArcEnd end) {
    end_ = end;
    return false;
  }

  /// As long as it takes to run through a hundredth of the stretch from rest, or at the present rate.
  double first_step() const {
    const ArcNode& now = arc_.back();
    const double way = 1e-2 * std::min(std::abs(until_ - now.s), stretch_.end - stretch_.begin);
    const double by_bend = now.u != 0 ? std::sqrt(2 * way / std::abs(now.u)) : INFINITY;
    const double by_rate = now.v != 0 ? way / now.v : INFINITY;
    const double h = std::min(by_bend, by_rate);
    return std::isfinite(h) ? h : 1e-3;
  }

  bool try_step(double h, ArcNode& next) {
    const ArcNode& now = arc_.back();
    std::array<PathState, 7> k{};
    k[0] = {sign_ * now.v, sign_ * now.u};
    for (std::size_t i = 0; i < stages.size(); ++i) {
      PathState at{now.s, now.v};
      for (std::size_t j = 0; j <= i; ++j) {
        at.s += h * stages[i][j] * k[j].s;
        at.v += h * stages[i][j] * k[j].v;
      }
      next = {now.t + h, at.s, std::max(at.v, 0.0), 0, -1};
      if (!look(next)) return false;
      k[i + 1] = {sign_ * next.v, sign_ * next.u};
    }
    PathState error;
    for (std::size_t i = 0; i < k.size(); ++i) {
      error.s += h * differences[i] * k[i].s;
      error.v += h * differences[i] * k[i].v;
    }
    error_ = std::max(std::abs(error.s) / place_tolerance,
                      std::abs(error.v) / (rate_tolerance * std::max(next.v, now.v) + 1e-300));
    return bends_alike(now, next);
  }

  /// Adds how far the quintic's s'' is off between nodes: a kink may hide from one place or two. @return false if nothing is
  /// allowed there
  bool bends_alike(const ArcNode& now, const ArcNode& next) {
    for (const double part : {0.2, 0.4, 0.6, 0.85}) {
      ArcNode inside = inside_of(now, next, part);
      const double bend = inside.u, size = std::max({std::abs(now.u), std::abs(next.u), width_});
      if (!look(inside)) return false;
      error_ = std::max(error_, std::abs(inside.u - bend) / (bend_tolerance * size));
    }
    return true;
  }

  ArcNode inside_of(const ArcNode& a, const ArcNode& b, double part) const {
    if (sign_ > 0) return between(a, b, a.t + part * (b.t - a.t));
    ArcNode first = b, second = a;  // in the order of time
    first.t = 0;
    second.t = b.t - a.t;
    return between(first, second, part * second.t);
  }

  /// Shortens a step that goes too far so that it ends where it should.
  bool land(double h, ArcNode& next) {
    const ArcNode& now = arc_.back();
    double shorter = h;
    for (int iteration = 0; iteration < 30; ++iteration) {
      const double miss = sign_ * (next.s - until_);
      if (std::abs(miss) <= 1e-15 || next.v <= 0) break;
      shorter -= miss / next.v;
      if (!(shorter > 0)) shorter = h / 2;
      if (!try_step(shorter, next)) return false;
    }
    next.s = until_;
    return next.t > now.t;
  }

  /// How far beyond the cap a node is, as a part of it.
  double excess(const ArcNode& node) {
    allowed_.go(node.s, stretch_.first_panel, stretch_.last_panel);
    const double x = under_ > 0 ? ceiling_here() : allowed_.cap().x;
    return node.v * node.v / x - 1;
  }

  double ceiling_here() {
    guess_ = allowed_.ceiling(guess_).x;
    return (1 - under_) * guess_;
  }

  /// Just under the ceiling where the rows with a leave a single s'' there, which may happen to follow it.
  bool look_under_ceiling(ArcNode& node) {
    const double step = slope_step * (stretch_.end - stretch_.begin), place = node.s;
    const auto at = [&](double s) {
      allowed_.go(s, stretch_.first_panel, stretch_.last_panel);
      return ceiling_here();
    };
    const double before = at(place - step), after = at(place + step), x = at(place);
    if (!std::isfinite(before + after + x) || !(x > 0)) return fails(ArcEnd::blocked);
    node.v = std::sqrt(x);
    node.u = (after - before) / (4 * step);
    const Interval interval = allowed_.at(x);
    if (interval.empty() || node.u < interval.low) return fails(ArcEnd::blocked);
    if (node.u > interval.high) return fails(ArcEnd::left);
    node.row = interval.high_row;
    width_ = std::max(std::abs(node.u), x / (stretch_.end - stretch_.begin));
    return true;
  }

  /// Whether a node on the cap can go on along it.
  bool climbs_along_cap(const ArcNode& node) {
    const Ceiling cap = allowed_.cap();
    return cap.row >= 0 && std::abs(node.v * node.v - cap.x) <= 1e-10 * cap.x &&
           node.u >= allowed_.along(cap.row, cap.x);
  }

  /// Shortens a step that goes beyond the cap so that it ends on it.
  bool land_on_cap(double h, ArcNode& next) {
    double low = 0, high = h;
    for (int halving = 0; halving < 60 && high - low > 1e-15 * h; ++halving) {
      const double middle = (low + high) / 2;
      if (!try_step(middle, next)) return false;
      (excess(next) > 0 ? high : low) = middle;
    }
    return low > 0 && try_step(low, next);
  }

  Allowed& allowed_;
  const Smooth& stretch_;
  Edge edge_;
  double sign_, until_;
  const Watcher& watcher_;
  double under_;
  double guess_ = 0;  ///< of the ceiling
  Arc& arc_;
  ArcEnd end_ = ArcEnd::arrived;
  double error_ = 0, width_ = 0, longest_ = 0;
};

}  // namespace

ArcNode between(const ArcNode& a, const ArcNode& b, double t) {
  const LawMoment here = join({a.t, a.s, a.v, a.u}, {b.t, b.s, b.v, b.u}, t);
  return {t, here.s, here.v, here.u, a.row};
}

ArcNode between_at(const ArcNode& a, const ArcNode& b, double s) {
  double low = a.t, high = b.t;
  double t = a.t + (b.t - a.t) * std::clamp((s - a.s) / (b.s - a.s), 0.0, 1.0);
  for (int iteration = 0; iteration < 60; ++iteration) {
    const ArcNode here = between(a, b, t);
    (here.s < s ? low : high) = t;
    const double next = here.v > 0 ? t - (here.s - s) / here.v : INFINITY;
    const double better = next > low && next < high ? next : (low + high) / 2;
    if (std::abs(better - t) <= 1e-16 * std::abs(b.t)) break;
    t = better;
  }
  ArcNode found = between(a, b, t);
  found.s = s;
  return found;
}

ArcEnd follow_edge(Allowed& allowed, const Smooth& stretch, Edge edge, double until, const Watcher& watcher, Arc& arc,
                   double under) {
  return Follower(allowed, stretch, edge, until, watcher, under, arc).run();
}

}  // namespace balance
