#include "balance/motion/time_optimal/phase_plane_integration.hpp"

#include "balance/foundation/base/elementary.hpp"
#include "balance/motion/time_optimal/time_optimal_law.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>

namespace balance {
namespace {

constexpr int scan_points = 400;                  // places of a leg at which the ceiling is looked at
constexpr double slope_step_fraction = 1e-6;      // of a leg: how far apart slopes of the ceiling are measured
constexpr double min_profile_length = 1e-9;       // of a leg: arcs shorter than this have not got away
constexpr double velocity_drop_tolerance = 1e-9;  // of the ceiling at a station, relative
constexpr std::size_t max_profiles = 500;

/// Where a braking arc leaves the ceiling.
struct SwitchPoint {
  double place = 0, x = 0;
  std::size_t stretch = 0;  ///< that it goes back into
  int zero_inertia = -1;
  ZeroInertia::Start start;
};

class ControllableSetBuilder {
 public:
  ControllableSetBuilder(AccelerationLimits& allowed, const SegmentRange& leg)
      : allowed_(allowed), leg_(leg), length_(leg.end - leg.begin) {}

  ControllableSet run(double end_rate) {
    SwitchPoint from{leg_.end, end_rate * end_rate, leg_.smooth_intervals.size() - 1, -1, {}};
    for (std::size_t arcs = 0;; ++arcs) {
      if (arcs == max_profiles || allowed_.has_reached_evaluation_limit())
        found_.refusal = format_path_parameter(from.place) + " the search for the law lost its way";
      const VelocityProfile arc = decelerate_into(from);
      if (!found_.refusal.empty()) return std::move(found_);
      if (arc.size() > 1) add_profile(arc, from);
      if (arc.back().s <= leg_.begin) break;
      const double at = arc.back().s;
      const bool away = from.place - at > min_profile_length * length_;
      const std::optional<SwitchPoint> next =
          find_switch_point(away ? at : std::max(leg_.begin, at - slope_step_fraction * length_));
      if (!next) break;
      from = *next;
    }
    std::reverse(found_.profiles.begin(), found_.profiles.end());
    return std::move(found_);
  }

 private:
  const SmoothInterval& interval(std::size_t k) const { return leg_.smooth_intervals[k]; }

  void move_to(double place, std::size_t k) {
    allowed_.move_to(place, interval(k).first_panel, interval(k).last_panel);
  }

  std::size_t interval_before(double place) const {
    std::size_t k = leg_.smooth_intervals.size() - 1;
    while (k > 0 && interval(k).begin >= place) --k;
    return k;
  }

  void add_profile(const VelocityProfile& backwards, const SwitchPoint& from) {
    DecelerationProfile arc{{}, from.zero_inertia};
    const double duration = backwards.back().t;
    for (auto node = backwards.rbegin(); node != backwards.rend(); ++node) {
      arc.points.push_back(*node);
      arc.points.back().t = duration - node->t;
    }
    found_.profiles.push_back(std::move(arc));
  }

  /// From a critical place back until nothing is allowed any more. Nodes run backwards.
  VelocityProfile decelerate_into(const SwitchPoint& from) {
    for (const double less : {0.0, 1e-11, 1e-10, 1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4}) {
      if (less == 0 && from.place != leg_.end) continue;
      VelocityProfile arc{{0, from.place, std::sqrt(from.x * (1 - less)), 0, -1}};
      if (from.start.is_on_row && less < 1e-10) {
        arc.back().v = std::sqrt(from.x);
        if (!step_from_zero_inertia(allowed_, interval(from.stretch), from.start, from.zero_inertia, -1, arc)) continue;
      }
      integrate_backwards(from.stretch, arc);
      if (from.place == leg_.end && arc.size() == 1 && found_.refusal.empty())
        found_.refusal = format_path_parameter(leg_.end) + " the limits leave nothing to stop with";
      if (!found_.refusal.empty() || from.place == leg_.end) return arc;
      if (from.place - arc.back().s > min_profile_length * length_) return arc;
    }
    return {{0, from.place, std::sqrt(from.x), 0, -1}};
  }

  void integrate_backwards(std::size_t k, VelocityProfile& arc) {
    for (;; --k) {
      const double until = interval(k).inner_begin();
      const StepCallback explodes = [&](const ProfilePoint&, const ProfilePoint& to) { return is_diverging(to, k); };
      const IntegrationEnd end =
          integrate_profile(allowed_, interval(k), ProfileKind::decelerate, until, explodes, arc);
      if (end == IntegrationEnd::unbounded) {
        found_.refusal = format_path_parameter(arc.back().s) +
                         " no limit bounds the acceleration: limit an effort, a force or an acceleration, too";
        return;
      }
      if (end != IntegrationEnd::reached_target || k == 0 || !is_velocity_feasible(k, arc.back())) return;
    }
  }

  /// Before a place of zero inertia speeds may grow without bound.
  bool is_diverging(const ProfilePoint& node, std::size_t k) {
    if (!interval(k).has_zero_inertia_begin ||
        node.s - interval(k).begin > 1e-3 * (interval(k).end - interval(k).begin))
      return false;
    move_to(interval(k).begin, k);
    return allowed_.drop_zero_inertia_rows() && node.v * node.v > 16 * allowed_.direct_velocity_bound().x;
  }

  /// Whether a speed is allowed at the station that a stretch begins with, and before it.
  bool is_velocity_feasible(std::size_t k, const ProfilePoint& node) {
    const double x = node.v * node.v;
    move_to(interval(k).begin, k);
    if (allowed_.drop_zero_inertia_rows() && allowed_.bounds(x).is_empty()) return false;
    move_to(interval(k).begin, k - 1);
    allowed_.drop_zero_inertia_rows();
    return !allowed_.bounds(x).is_empty();
  }

  /// The first place backwards where the ceiling cannot be followed into from before: braking has to begin below it.
  std::optional<SwitchPoint> find_switch_point(double from) {
    std::size_t k = interval_before(from);
    if (const bool at_station = k + 1 < leg_.smooth_intervals.size() && from == interval(k).end; at_station)
      if (const auto critical = switch_point_at_breakpoint(k + 1)) return critical;
    double right = from;
    while (true) {
      if (const auto critical = switch_point_inside(k, right)) return critical;
      if (k == 0) return std::nullopt;
      if (const auto critical = switch_point_at_breakpoint(k)) return critical;
      right = interval(--k).end;
    }
  }

  /// At the station between a stretch and the one before.
  std::optional<SwitchPoint> switch_point_at_breakpoint(std::size_t k) {
    const double place = interval(k).begin;
    move_to(place, k);
    const bool vanishes = allowed_.drop_zero_inertia_rows();
    const VelocityBound here = allowed_.max_velocity();
    if (vanishes && allowed_.is_dropped(here.row)) {
      const ZeroInertia::Start start = ZeroInertia::profile_start(allowed_, here.row, here.x, -1);
      if (start.is_feasible) return SwitchPoint{place, here.x, k - 1, here.row, start};
      return std::nullopt;
    }
    move_to(place, k - 1);
    allowed_.drop_zero_inertia_rows();
    if (allowed_.max_velocity().x > here.x * (1 + velocity_drop_tolerance))
      return SwitchPoint{place, here.x, k - 1, -1, {}};
    return std::nullopt;
  }

  /// Whether the ceiling falls faster than one can brake: the arc that brakes into it comes from below.
  bool is_falling_faster_than_deceleration(double place, std::size_t k, double& x) {
    const double step = std::min(slope_step_fraction * length_, (place - interval(k).begin) / 2);
    if (!(step > 0)) return false;
    move_to(place, k);
    x = allowed_.max_velocity(x).x;
    if (!std::isfinite(x)) return x = 0, false;
    double low = NAN;
    for (double less = 1e-12; less < 1e-6 && std::isnan(low); less *= 10)
      if (const AccelerationInterval interval = allowed_.bounds(x * (1 - less)); !interval.is_empty())
        low = interval.lower;
    if (std::isnan(low)) return false;
    move_to(place - step, k);
    const double before = allowed_.max_velocity(x).x;
    // where both fall alike the ceiling itself can be followed
    const double margin = 1e-6 * step * (x / length_ + 2 * std::abs(low));
    return x - 2 * low * step < before - margin;
  }

  std::optional<SwitchPoint> switch_point_inside(std::size_t k, double right) {
    const double width = length_ / scan_points;
    double x = 0;
    if (right == interval(k).end && interval(k).has_zero_inertia_end)
      right -= std::min(1e-3 * width, (right - interval(k).begin) / 2);
    if (is_falling_faster_than_deceleration(right, k, x) && x > 0) return SwitchPoint{right, x, k, -1, {}};
    for (double last = right; last > interval(k).begin;) {
      const double next = std::max(last - width, interval(k).begin + 1e-3 * width);
      if (next >= last) break;
      if (!is_falling_faster_than_deceleration(next, k, x)) {
        last = next;
        continue;
      }
      double low = next, high = last;
      for (int halving = 0; halving < 40; ++halving) {
        const double middle = (low + high) / 2;
        (is_falling_faster_than_deceleration(middle, k, x) ? low : high) = middle;
      }
      is_falling_faster_than_deceleration(low, k, x);
      return SwitchPoint{low, x, k, -1, {}};
    }
    return std::nullopt;
  }

  AccelerationLimits& allowed_;
  const SegmentRange& leg_;
  double length_;
  ControllableSet found_;
};

}  // namespace

const DecelerationProfile* ControllableSet::profile_at(double place) const {
  const auto next = std::upper_bound(profiles.begin(), profiles.end(), place,
                                     [](double p, const DecelerationProfile& arc) { return p < arc.begin(); });
  if (next == profiles.begin()) return nullptr;
  const DecelerationProfile& arc = *(next - 1);
  return place <= arc.end() ? &arc : nullptr;
}

ControllableSet compute_controllable_set(AccelerationLimits& allowed, const SegmentRange& leg, double end_rate) {
  return ControllableSetBuilder(allowed, leg).run(end_rate);
}

ProfilePoint interpolate_profile(const VelocityProfile& arc, double place) {
  const auto next = std::upper_bound(arc.begin() + 1, arc.end() - 1, place,
                                     [](double p, const ProfilePoint& node) { return p < node.s; });
  return interpolate_at_parameter(*(next - 1), *next, place);
}

std::string format_path_parameter(double place) {
  char text[64];
  std::snprintf(text, sizeof text, "at %.6g %% of the path", 100 * place);
  return text;
}

namespace {

constexpr double min_progress_fraction = 1e-9;  // of a leg
constexpr double node_time_tolerance = 1e-9;    // of the time so far: nodes nearer to each other are one
constexpr double min_velocity_margin = 1e-9;    // of the ceiling's x: followed so far below it
constexpr double max_velocity_margin = 1e-6;
constexpr int max_switches = 500;  // between speeding up, sliding and braking

class PhasePlaneSolver {
 public:
  PhasePlaneSolver(AccelerationLimits& allowed, const SegmentRange& leg, const ControllableSet& bound,
                   const EndpointRates& rates)
      : allowed_(allowed), leg_(leg), bound_(bound), rates_(rates) {}

  /// Appends the leg's nodes.
  std::string run(std::vector<TimeLawNode>& nodes) {
    nodes_ = &nodes;
    start_ = nodes.empty() ? 0 : nodes.back().t;
    if (const DecelerationProfile* first = bound_.profile_at(leg_.begin); first != nullptr) {
      const double most = first->points.front().v;
      if (rates_.start > most * (1 + 1e-9)) return "the motion starts faster than it could brake within its limits";
    }
    VelocityProfile arc{{0, leg_.begin, rates_.start, 0, -1}};
    int vanished = -1;
    for (int turn = 0; turn < max_switches; ++turn) {
      const DecelerationProfile* braking = accelerate_to_profile(arc, vanished);
      append(arc);
      if (!refusal_.empty()) return refusal_;
      if (braking == nullptr) return "the end's speed cannot be reached from the start within the limits";
      VelocityProfile rest = profile_from(*braking, arc.back().s);
      vanished = braking->zero_inertia_row;
      passed_profiles_ = static_cast<std::size_t>(braking - bound_.profiles.data()) + 1;
      if (braking->end() >= leg_.end) {
        append(rest);
        return "";
      }
      if (vanished < 0) shorten_to_feasible(rest);
      arc = {{0, rest.back().s, rest.back().v, rest.back().u, rest.back().row}};
      append(rest);
    }
    return search_failed(arc.back().s);
  }

 private:
  std::string search_failed(double place) const {
    return format_path_parameter(place) + " the search for the law lost its way";
  }

  std::size_t interval_from(double place) const {
    std::size_t k = 0;
    while (k + 1 < leg_.smooth_intervals.size() && leg_.smooth_intervals[k].inner_end() <= place) ++k;
    return k;
  }

  /// From the last node on, until a braking arc is met, whose first point the arc then ends with.
  /// @return null: the leg's end was reached
  const DecelerationProfile* accelerate_to_profile(VelocityProfile& arc, int vanished) {
    const DecelerationProfile* met = nullptr;
    const StepCallback watcher = [&](const ProfilePoint& from, const ProfilePoint& to) {
      met = find_crossing(from, to, arc);
      return met != nullptr;
    };
    std::size_t k = interval_from(arc.back().s);
    if (vanished >= 0) leave_zero_inertia_point(arc, k, vanished);
    ProfileKind edge = ProfileKind::accelerate;
    double under = 0;  // the ceiling, if it is followed
    for (int turn = 0; turn < max_switches; ++turn) {
      const SmoothInterval& stretch = leg_.smooth_intervals[k];
      const double place = arc.back().s;
      const DecelerationProfile* ahead =
          edge == ProfileKind::slide && under == 0 ? next_profile_within(stretch, place) : nullptr;
      const std::size_t nodes = arc.size();
      const double until = ahead != nullptr ? ahead->begin() : stretch.inner_end();
      const IntegrationEnd end = integrate_profile(allowed_, stretch, edge, until, watcher, arc, under);
      if (met != nullptr) return met;
      if (end == IntegrationEnd::infeasible_start) {
        refusal_ = format_path_parameter(place) + " the limits leave nothing to move off with";
        return nullptr;
      }
      if (end == IntegrationEnd::unbounded) {
        refusal_ = format_path_parameter(arc.back().s) +
                   " no limit bounds the acceleration: limit an effort, a force or an acceleration, too";
        return nullptr;
      }
      if (end == IntegrationEnd::reached_target && ahead != nullptr) return ahead;
      if (end == IntegrationEnd::reached_target) {
        if (++k == leg_.smooth_intervals.size()) return nullptr;
        continue;
      }
      if (end == IntegrationEnd::hit_velocity_bound) {
        edge = ProfileKind::slide;
      } else if (end == IntegrationEnd::left_velocity_bound) {
        edge = ProfileKind::accelerate;
        under = 0;
      } else if (end == IntegrationEnd::infeasible && reaches_next_profile(arc, met)) {
        return met;
      } else if (end == IntegrationEnd::infeasible && edge == ProfileKind::accelerate && under == 0) {
        arc.resize(nodes);  // once more, up to just under the ceiling
        under = choose_velocity_margin(stretch, place);
      } else if (arc.back().s - place < min_progress_fraction * (leg_.end - leg_.begin)) {
        refusal_ = search_failed(arc.back().s);
        return nullptr;
      }
    }
    refusal_ = search_failed(arc.back().s);
    return nullptr;
  }

  /// How near to the ceiling it is followed: as near as the next braking arc has come to it.
  double choose_velocity_margin(const SmoothInterval& stretch, double place) const {
    const DecelerationProfile* next = next_profile_within(stretch, place);
    if (next == nullptr) return min_velocity_margin;
    allowed_.move_to(next->begin(), stretch.first_panel, stretch.last_panel);
    const double v = next->points.front().v;
    return std::clamp(2 * (1 - v * v / allowed_.max_velocity().x), min_velocity_margin, max_velocity_margin);
  }

  /// Out of a place of zero inertia along the row that vanishes there.
  void leave_zero_inertia_point(VelocityProfile& arc, std::size_t k, int row) {
    const SmoothInterval& stretch = leg_.smooth_intervals[k];
    allowed_.move_to(arc.back().s, stretch.first_panel, stretch.last_panel);
    allowed_.drop_zero_inertia_rows();
    const double x = arc.back().v * arc.back().v;
    const ZeroInertia::Start start = ZeroInertia::profile_start(allowed_, row, x, 1);
    if (start.is_feasible && start.is_on_row) step_from_zero_inertia(allowed_, stretch, start, row, 1, arc);
  }

  /// The next braking arc, if it begins on a stretch.
  const DecelerationProfile* next_profile_within(const SmoothInterval& stretch, double place) const {
    for (std::size_t i = passed_profiles_; i < bound_.profiles.size(); ++i)
      if (bound_.profiles[i].begin() > place)
        return bound_.profiles[i].begin() < stretch.inner_end() ? &bound_.profiles[i] : nullptr;
    return nullptr;
  }

  /// A slide or a touch that ends where the next braking arc begins.
  bool reaches_next_profile(VelocityProfile& arc, const DecelerationProfile*& met) const {
    for (std::size_t i = passed_profiles_; i < bound_.profiles.size(); ++i) {
      const DecelerationProfile& next = bound_.profiles[i];
      if (next.end() <= arc.back().s) continue;
      const double ahead = next.begin() - arc.back().s;
      if (ahead > 1e-6 * (leg_.end - leg_.begin)) return false;
      met = &next;
      return true;
    }
    return false;
  }

  /// Whether a step goes beyond a braking arc: then its end is put onto the arc.
  const DecelerationProfile* find_crossing(const ProfilePoint& from, const ProfilePoint& to,
                                           VelocityProfile& arc) const {
    double below = from.s;
    const auto beyond = [&](double place, const DecelerationProfile& braking) {
      return interpolate_at_parameter(from, to, place).v > interpolate_profile(braking.points, place).v;
    };
    for (std::size_t i = passed_profiles_; i < bound_.profiles.size(); ++i) {
      const DecelerationProfile& braking = bound_.profiles[i];
      if (braking.end() < from.s) continue;
      if (braking.begin() > to.s) break;
      std::vector<double> places;
      for (const ProfilePoint& node : braking.points)
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
        arc.back() = truncate_step(from, to, low);
        return &braking;
      }
    }
    return nullptr;
  }

  /// The end of a step that is cut short.
  static ProfilePoint truncate_step(const ProfilePoint& from, const ProfilePoint& to, double place) {
    ProfilePoint node = interpolate_at_parameter(from, to, place);
    node.row = from.row;
    return node;
  }

  static VelocityProfile profile_from(const DecelerationProfile& braking, double place) {
    const double from = std::max(place, braking.begin());
    VelocityProfile rest{interpolate_profile(braking.points, from)};
    for (const ProfilePoint& node : braking.points)
      if (node.s > from) rest.push_back(node);
    rest.front().row = rest.size() > 1 ? rest[1].row : -1;
    const double first = rest.front().t;
    for (ProfilePoint& node : rest) node.t -= first;
    return rest;
  }

  /// Where a braking arc is left for speeding up: its end or, where nothing is allowed there, just before.
  void shorten_to_feasible(VelocityProfile& rest) {
    for (int tries = 0; tries < 6 && rest.size() > 1; ++tries) {
      ProfilePoint& last = rest.back();
      const std::size_t k = interval_from(last.s);
      allowed_.move_to(last.s, leg_.smooth_intervals[k].first_panel, leg_.smooth_intervals[k].last_panel);
      if (!allowed_.bounds(last.v * last.v * (1 - 1e-12)).is_empty()) break;
      const ProfilePoint& before = rest[rest.size() - 2];
      const double back = elementary::pow(10, tries - 8) * (leg_.end - leg_.begin);
      if (last.s - back <= before.s) {
        rest.pop_back();
        continue;
      }
      const int row = last.row;
      last = interpolate_at_parameter(before, last, last.s - back);
      last.row = row;
    }
  }

  void append(const VelocityProfile& arc) {
    for (const ProfilePoint& node : arc) {
      if (&node == &arc.front() && !nodes_->empty()) {
        nodes_->back().u_after = node.u;
        nodes_->back().row_after = arc.size() > 1 ? node.row : nodes_->back().row_after;
        continue;
      }
      if (const double t = start_ + node.t; !nodes_->empty() && t - nodes_->back().t <= node_time_tolerance * t) {
        const TimeLawNode last = nodes_->back();
        nodes_->back() = {t, node.s, node.v, last.u_before, node.u, node.row};
        continue;
      }
      nodes_->push_back({start_ + node.t, node.s, node.v, node.u, node.u, node.row});
    }
    start_ = nodes_->back().t;
  }

  AccelerationLimits& allowed_;
  const SegmentRange& leg_;
  const ControllableSet& bound_;
  EndpointRates rates_;
  std::size_t passed_profiles_ = 0;  ///< braking arcs that lie behind
  double start_ = 0;
  std::vector<TimeLawNode>* nodes_ = nullptr;
  std::string refusal_;
};

}  // namespace

TimeOptimalLaw integrate_phase_plane(const PathModel& model, const std::vector<double>& bounds, const SegmentRange& leg,
                                     const EndpointRates& rates) {
  AccelerationLimits allowed(model, bounds);
  TimeOptimalLaw law;
  const ControllableSet bound = compute_controllable_set(allowed, leg, rates.end);
  law.infeasibility_reason =
      bound.refusal.empty() ? PhasePlaneSolver(allowed, leg, bound, rates).run(law.nodes) : bound.refusal;
  return law;
}

}  // namespace balance
