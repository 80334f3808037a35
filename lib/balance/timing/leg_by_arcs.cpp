#include "balance/timing/leg_by_arcs.hpp"

#include "balance/base/elementary.hpp"

#include <algorithm>
#include <cmath>

namespace balance {
namespace {

constexpr double stands_still = 1e-9;  // of a leg
constexpr double one_time = 1e-9;      // of the time so far: nodes nearer to each other are one
constexpr double least_under = 1e-9;   // of the ceiling's x: followed so far below it
constexpr double most_under = 1e-6;
constexpr int most_turns = 500;  // between speeding up, sliding and braking

class LegTiming {
 public:
  LegTiming(Allowed& allowed, const LegOfPath& leg, const Controllable& bound, const EndRates& rates)
      : allowed_(allowed), leg_(leg), bound_(bound), rates_(rates) {}

  /// Appends the leg's nodes.
  std::string run(std::vector<TimedNode>& nodes) {
    nodes_ = &nodes;
    start_ = nodes.empty() ? 0 : nodes.back().t;
    if (const BrakingArc* first = bound_.at(leg_.begin); first != nullptr) {
      const double most = first->nodes.front().v;
      if (rates_.start > most * (1 + 1e-9)) return "the motion starts faster than it could brake within its limits";
    }
    Arc arc{{0, leg_.begin, rates_.start, 0, -1}};
    int vanished = -1;
    for (int turn = 0; turn < most_turns; ++turn) {
      const BrakingArc* braking = speed_up(arc, vanished);
      append(arc);
      if (!refusal_.empty()) return refusal_;
      if (braking == nullptr) return "the end's speed cannot be reached from the start within the limits";
      Arc rest = remainder(*braking, arc.back().s);
      vanished = braking->zero_inertia;
      passed_ = static_cast<std::size_t>(braking - bound_.arcs.data()) + 1;
      if (braking->end() >= leg_.end) {
        append(rest);
        return "";
      }
      if (vanished < 0) leave(rest);
      arc = {{0, rest.back().s, rest.back().v, rest.back().u, rest.back().row}};
      append(rest);
    }
    return lost(arc.back().s);
  }

 private:
  std::string lost(double place) const { return place_text(place) + " the search for the law lost its way"; }

  std::size_t stretch_from(double place) const {
    std::size_t k = 0;
    while (k + 1 < leg_.stretches.size() && leg_.stretches[k].near_end() <= place) ++k;
    return k;
  }

  /// From the last node on, until a braking arc is met, whose first point the arc then ends with.
  /// @return null: the leg's end was reached
  const BrakingArc* speed_up(Arc& arc, int vanished) {
    const BrakingArc* met = nullptr;
    const Watcher watcher = [&](const ArcNode& from, const ArcNode& to) {
      met = crossing(from, to, arc);
      return met != nullptr;
    };
    std::size_t k = stretch_from(arc.back().s);
    if (vanished >= 0) step_out(arc, k, vanished);
    Edge edge = Edge::speed_up;
    double under = 0;  // the ceiling, if it is followed
    for (int turn = 0; turn < most_turns; ++turn) {
      const Smooth& stretch = leg_.stretches[k];
      const double place = arc.back().s;
      const BrakingArc* ahead = edge == Edge::slide && under == 0 ? next_within(stretch, place) : nullptr;
      const std::size_t nodes = arc.size();
      const double until = ahead != nullptr ? ahead->begin() : stretch.near_end();
      const ArcEnd end = follow_edge(allowed_, stretch, edge, until, watcher, arc, under);
      if (met != nullptr) return met;
      if (end == ArcEnd::stuck) {
        refusal_ = place_text(place) + " the limits leave nothing to move off with";
        return nullptr;
      }
      if (end == ArcEnd::unlimited) {
        refusal_ = place_text(arc.back().s) +
                   " no limit bounds the acceleration: limit an effort, a force or an acceleration, too";
        return nullptr;
      }
      if (end == ArcEnd::arrived && ahead != nullptr) return ahead;
      if (end == ArcEnd::arrived) {
        if (++k == leg_.stretches.size()) return nullptr;
        continue;
      }
      if (end == ArcEnd::capped) {
        edge = Edge::slide;
      } else if (end == ArcEnd::left) {
        edge = Edge::speed_up;
        under = 0;
      } else if (end == ArcEnd::blocked && meets_next(arc, met)) {
        return met;
      } else if (end == ArcEnd::blocked && edge == Edge::speed_up && under == 0) {
        arc.resize(nodes);  // once more, up to just under the ceiling
        under = under_ceiling(stretch, place);
      } else if (arc.back().s - place < stands_still * (leg_.end - leg_.begin)) {
        refusal_ = lost(arc.back().s);
        return nullptr;
      }
    }
    refusal_ = lost(arc.back().s);
    return nullptr;
  }

  /// How near to the ceiling it is followed: as near as the next braking arc has come to it.
  double under_ceiling(const Smooth& stretch, double place) const {
    const BrakingArc* next = next_within(stretch, place);
    if (next == nullptr) return least_under;
    allowed_.go(next->begin(), stretch.first_panel, stretch.last_panel);
    const double v = next->nodes.front().v;
    return std::clamp(2 * (1 - v * v / allowed_.ceiling().x), least_under, most_under);
  }

  /// Out of a place of zero inertia along the row that vanishes there.
  void step_out(Arc& arc, std::size_t k, int row) {
    const Smooth& stretch = leg_.stretches[k];
    allowed_.go(arc.back().s, stretch.first_panel, stretch.last_panel);
    allowed_.drop_inertia();
    const double x = arc.back().v * arc.back().v;
    const ZeroInertia::Start start = ZeroInertia::start(allowed_, row, x, 1);
    if (start.possible && start.along_row) step_off(allowed_, stretch, start, row, 1, arc);
  }

  /// The next braking arc, if it begins on a stretch.
  const BrakingArc* next_within(const Smooth& stretch, double place) const {
    for (std::size_t i = passed_; i < bound_.arcs.size(); ++i)
      if (bound_.arcs[i].begin() > place)
        return bound_.arcs[i].begin() < stretch.near_end() ? &bound_.arcs[i] : nullptr;
    return nullptr;
  }

  /// A slide or a touch that ends where the next braking arc begins.
  bool meets_next(Arc& arc, const BrakingArc*& met) const {
    for (std::size_t i = passed_; i < bound_.arcs.size(); ++i) {
      const BrakingArc& next = bound_.arcs[i];
      if (next.end() <= arc.back().s) continue;
      const double ahead = next.begin() - arc.back().s;
      if (ahead > 1e-6 * (leg_.end - leg_.begin)) return false;
      met = &next;
      return true;
    }
    return false;
  }

  /// Whether a step goes beyond a braking arc: then its end is put onto the arc.
  const BrakingArc* crossing(const ArcNode& from, const ArcNode& to, Arc& arc) const {
    double below = from.s;
    const auto beyond = [&](double place, const BrakingArc& braking) {
      return between_at(from, to, place).v > node_at(braking.nodes, place).v;
    };
    for (std::size_t i = passed_; i < bound_.arcs.size(); ++i) {
      const BrakingArc& braking = bound_.arcs[i];
      if (braking.end() < from.s) continue;
      if (braking.begin() > to.s) break;
      std::vector<double> places;
      for (const ArcNode& node : braking.nodes)
        if (node.s > from.s && node.s < to.s) places.push_back(node.s);
      if (to.s <= braking.end()) places.push_back(to.s);
      for (const double place : places) {
        if (!beyond(place, braking)) {
          below = place;
          continue;
        }
        double low = std::max(below, braking.begin()), high = place;
        for (int halving = 0; halving < 60 && high - low > 1e-16; ++halving) {
          const double middle = (low + high) / 2;
          (beyond(middle, braking) ? high : low) = middle;
        }
        arc.back() = cut(from, to, low);
        return &braking;
      }
    }
    return nullptr;
  }

  /// The end of a step that is cut short.
  static ArcNode cut(const ArcNode& from, const ArcNode& to, double place) {
    ArcNode node = between_at(from, to, place);
    node.row = from.row;
    return node;
  }

  static Arc remainder(const BrakingArc& braking, double place) {
    const double from = std::max(place, braking.begin());
    Arc rest{node_at(braking.nodes, from)};
    for (const ArcNode& node : braking.nodes)
      if (node.s > from) rest.push_back(node);
    rest.front().row = rest.size() > 1 ? rest[1].row : -1;
    const double first = rest.front().t;
    for (ArcNode& node : rest) node.t -= first;
    return rest;
  }

  /// Where a braking arc is left for speeding up: its end or, where nothing is allowed there, just before.
  void leave(Arc& rest) {
    for (int tries = 0; tries < 6 && rest.size() > 1; ++tries) {
      ArcNode& last = rest.back();
      const std::size_t k = stretch_from(last.s);
      allowed_.go(last.s, leg_.stretches[k].first_panel, leg_.stretches[k].last_panel);
      if (!allowed_.at(last.v * last.v * (1 - 1e-12)).empty()) break;
      const ArcNode& before = rest[rest.size() - 2];
      const double back = elementary::pow(10, tries - 8) * (leg_.end - leg_.begin);
      if (last.s - back <= before.s) {
        rest.pop_back();
        continue;
      }
      const int row = last.row;
      last = between_at(before, last, last.s - back);
      last.row = row;
    }
  }

  void append(const Arc& arc) {
    for (const ArcNode& node : arc) {
      if (&node == &arc.front() && !nodes_->empty()) {
        nodes_->back().u_after = node.u;
        nodes_->back().row_after = arc.size() > 1 ? node.row : nodes_->back().row_after;
        continue;
      }
      if (const double t = start_ + node.t; !nodes_->empty() && t - nodes_->back().t <= one_time * t) {
        const TimedNode last = nodes_->back();
        nodes_->back() = {t, node.s, node.v, last.u_before, node.u, node.row};
        continue;
      }
      nodes_->push_back({start_ + node.t, node.s, node.v, node.u, node.u, node.row});
    }
    start_ = nodes_->back().t;
  }

  Allowed& allowed_;
  const LegOfPath& leg_;
  const Controllable& bound_;
  EndRates rates_;
  std::size_t passed_ = 0;  ///< braking arcs that lie behind
  double start_ = 0;
  std::vector<TimedNode>* nodes_ = nullptr;
  std::string refusal_;
};

}  // namespace

FastestLaw find_leg_by_arcs(const PathModel& model, const std::vector<double>& bounds, const LegOfPath& leg,
                            const EndRates& rates) {
  Allowed allowed(model, bounds);
  FastestLaw law;
  const Controllable bound = find_controllable(allowed, leg, rates.end);
  law.refusal = bound.refusal.empty() ? LegTiming(allowed, leg, bound, rates).run(law.nodes) : bound.refusal;
  return law;
}

}  // namespace balance
