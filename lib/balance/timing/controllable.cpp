#include "balance/timing/controllable.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>

namespace balance {
namespace {

constexpr int scanned = 400;         // places of a leg at which the ceiling is looked at
constexpr double probe = 1e-6;       // of a leg: how far apart slopes of the ceiling are measured
constexpr double got_away = 1e-9;    // of a leg: arcs shorter than this have not got away
constexpr double least_drop = 1e-9;  // of the ceiling at a station, relative
constexpr std::size_t most_arcs = 500;

/// Where a braking arc leaves the ceiling.
struct Critical {
  double place = 0, x = 0;
  std::size_t stretch = 0;  ///< that it goes back into
  int zero_inertia = -1;
  ZeroInertia::Start start;
};

class Marcher {
 public:
  Marcher(Allowed& allowed, const LegOfPath& leg) : allowed_(allowed), leg_(leg), length_(leg.end - leg.begin) {}

  Controllable run(double end_rate) {
    Critical from{leg_.end, end_rate * end_rate, leg_.stretches.size() - 1, -1, {}};
    for (std::size_t arcs = 0;; ++arcs) {
      if (arcs == most_arcs || allowed_.exhausted())
        found_.refusal = place_text(from.place) + " the search for the law lost its way";
      const Arc arc = brake_into(from);
      if (!found_.refusal.empty()) return std::move(found_);
      if (arc.size() > 1) keep(arc, from);
      if (arc.back().s <= leg_.begin) break;
      const double at = arc.back().s;
      const bool away = from.place - at > got_away * length_;
      const std::optional<Critical> next = find_critical(away ? at : std::max(leg_.begin, at - probe * length_));
      if (!next) break;
      from = *next;
    }
    std::reverse(found_.arcs.begin(), found_.arcs.end());
    return std::move(found_);
  }

 private:
  const Smooth& stretch(std::size_t k) const { return leg_.stretches[k]; }

  void go(double place, std::size_t k) { allowed_.go(place, stretch(k).first_panel, stretch(k).last_panel); }

  std::size_t stretch_before(double place) const {
    std::size_t k = leg_.stretches.size() - 1;
    while (k > 0 && stretch(k).begin >= place) --k;
    return k;
  }

  void keep(const Arc& backwards, const Critical& from) {
    BrakingArc arc{{}, from.zero_inertia};
    const double duration = backwards.back().t;
    for (auto node = backwards.rbegin(); node != backwards.rend(); ++node) {
      arc.nodes.push_back(*node);
      arc.nodes.back().t = duration - node->t;
    }
    found_.arcs.push_back(std::move(arc));
  }

  /// From a critical place back until nothing is allowed any more. Nodes run backwards.
  Arc brake_into(const Critical& from) {
    for (const double less : {0.0, 1e-11, 1e-10, 1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4}) {
      if (less == 0 && from.place != leg_.end) continue;
      Arc arc{{0, from.place, std::sqrt(from.x * (1 - less)), 0, -1}};
      if (from.start.along_row && less < 1e-10) {
        arc.back().v = std::sqrt(from.x);
        if (!step_off(allowed_, stretch(from.stretch), from.start, from.zero_inertia, -1, arc)) continue;
      }
      follow(from.stretch, arc);
      if (from.place == leg_.end && arc.size() == 1 && found_.refusal.empty())
        found_.refusal = place_text(leg_.end) + " the limits leave nothing to stop with";
      if (!found_.refusal.empty() || from.place == leg_.end) return arc;
      if (from.place - arc.back().s > got_away * length_) return arc;
    }
    return {{0, from.place, std::sqrt(from.x), 0, -1}};
  }

  void follow(std::size_t k, Arc& arc) {
    for (;; --k) {
      const double until = stretch(k).near_begin();
      const Watcher explodes = [&](const ArcNode&, const ArcNode& to) { return runs_away(to, k); };
      const ArcEnd end = follow_edge(allowed_, stretch(k), Edge::brake, until, explodes, arc);
      if (end == ArcEnd::unlimited) {
        found_.refusal = place_text(arc.back().s) +
                         " no limit bounds the acceleration: limit an effort, a force or an acceleration, too";
        return;
      }
      if (end != ArcEnd::arrived || k == 0 || !passes(k, arc.back())) return;
    }
  }

  /// Before a place of zero inertia speeds may grow without bound.
  bool runs_away(const ArcNode& node, std::size_t k) {
    if (!stretch(k).vanishes_at_begin || node.s - stretch(k).begin > 1e-3 * (stretch(k).end - stretch(k).begin))
      return false;
    go(stretch(k).begin, k);
    return allowed_.drop_inertia() && node.v * node.v > 16 * allowed_.cap().x;
  }

  /// Whether a speed is allowed at the station that a stretch begins with, and before it.
  bool passes(std::size_t k, const ArcNode& node) {
    const double x = node.v * node.v;
    go(stretch(k).begin, k);
    if (allowed_.drop_inertia() && allowed_.at(x).empty()) return false;
    go(stretch(k).begin, k - 1);
    allowed_.drop_inertia();
    return !allowed_.at(x).empty();
  }

  /// The first place backwards where the ceiling cannot be followed into from before: braking has to begin below it.
  std::optional<Critical> find_critical(double from) {
    std::size_t k = stretch_before(from);
    if (const bool at_station = k + 1 < leg_.stretches.size() && from == stretch(k).end; at_station)
      if (const auto critical = at(k + 1)) return critical;
    double right = from;
    while (true) {
      if (const auto critical = inside(k, right)) return critical;
      if (k == 0) return std::nullopt;
      if (const auto critical = at(k)) return critical;
      right = stretch(--k).end;
    }
  }

  /// At the station between a stretch and the one before.
  std::optional<Critical> at(std::size_t k) {
    const double place = stretch(k).begin;
    go(place, k);
    const bool vanishes = allowed_.drop_inertia();
    const Ceiling here = allowed_.ceiling();
    if (vanishes && allowed_.has_dropped(here.row)) {
      const ZeroInertia::Start start = ZeroInertia::start(allowed_, here.row, here.x, -1);
      if (start.possible) return Critical{place, here.x, k - 1, here.row, start};
      return std::nullopt;
    }
    go(place, k - 1);
    allowed_.drop_inertia();
    if (allowed_.ceiling().x > here.x * (1 + least_drop)) return Critical{place, here.x, k - 1, -1, {}};
    return std::nullopt;
  }

  /// Whether the ceiling falls faster than one can brake: the arc that brakes into it comes from below.
  bool falls(double place, std::size_t k, double& x) {
    const double step = std::min(probe * length_, (place - stretch(k).begin) / 2);
    if (!(step > 0)) return false;
    go(place, k);
    x = allowed_.ceiling(x).x;
    if (!std::isfinite(x)) return x = 0, false;
    double low = NAN;
    for (double less = 1e-12; less < 1e-6 && std::isnan(low); less *= 10)
      if (const Interval interval = allowed_.at(x * (1 - less)); !interval.empty()) low = interval.low;
    if (std::isnan(low)) return false;
    go(place - step, k);
    const double before = allowed_.ceiling(x).x;
    // where both fall alike the ceiling itself can be followed
    const double margin = 1e-6 * step * (x / length_ + 2 * std::abs(low));
    return x - 2 * low * step < before - margin;
  }

  std::optional<Critical> inside(std::size_t k, double right) {
    const double width = length_ / scanned;
    double x = 0;
    if (right == stretch(k).end && stretch(k).vanishes_at_end)
      right -= std::min(1e-3 * width, (right - stretch(k).begin) / 2);
    if (falls(right, k, x) && x > 0) return Critical{right, x, k, -1, {}};
    for (double last = right; last > stretch(k).begin;) {
      const double next = std::max(last - width, stretch(k).begin + 1e-3 * width);
      if (next >= last) break;
      if (!falls(next, k, x)) {
        last = next;
        continue;
      }
      double low = next, high = last;
      for (int halving = 0; halving < 40; ++halving) {
        const double middle = (low + high) / 2;
        (falls(middle, k, x) ? low : high) = middle;
      }
      falls(low, k, x);
      return Critical{low, x, k, -1, {}};
    }
    return std::nullopt;
  }

  Allowed& allowed_;
  const LegOfPath& leg_;
  double length_;
  Controllable found_;
};

}  // namespace

const BrakingArc* Controllable::at(double place) const {
  const auto next = std::upper_bound(arcs.begin(), arcs.end(), place,
                                     [](double p, const BrakingArc& arc) { return p < arc.begin(); });
  if (next == arcs.begin()) return nullptr;
  const BrakingArc& arc = *(next - 1);
  return place <= arc.end() ? &arc : nullptr;
}

Controllable find_controllable(Allowed& allowed, const LegOfPath& leg, double end_rate) {
  return Marcher(allowed, leg).run(end_rate);
}

ArcNode node_at(const Arc& arc, double place) {
  const auto next =
      std::upper_bound(arc.begin() + 1, arc.end() - 1, place, [](double p, const ArcNode& node) { return p < node.s; });
  return between_at(*(next - 1), *next, place);
}

std::string place_text(double place) {
  char text[64];
  std::snprintf(text, sizeof text, "at %.6g %% of the path", 100 * place);
  return text;
}

}  // namespace balance
