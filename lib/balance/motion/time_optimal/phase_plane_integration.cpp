#include "balance/motion/time_optimal/phase_plane_integration.hpp"

#include "balance/foundation/base/elementary.hpp"
#include "balance/motion/time_optimal/time_optimal_law.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>

namespace balance::time_optimal {
namespace {

constexpr int scan_points = 400;                  // per leg, for examining the maximum velocity curve
constexpr double slope_step_fraction = 1e-6;      // of a leg: step for slopes of the maximum velocity curve
constexpr double min_profile_length = 1e-9;       // of a leg: shorter profiles make no progress
constexpr double velocity_drop_tolerance = 1e-9;  // of the maximum velocity at a breakpoint, relative
constexpr std::size_t max_profiles = 500;

/// A point at which a deceleration profile leaves the maximum velocity curve.
struct SwitchPoint {
  double s = 0, x = 0;
  std::size_t interval_index = 0;  ///< of the interval before it
  int zero_inertia = -1;
  ZeroInertia::Start start;
};

class ControllableSetBuilder {
 public:
  ControllableSetBuilder(AccelerationLimits& limits, const SegmentRange& leg)
      : limits_(limits), leg_(leg), length_(leg.end - leg.begin) {}

  ControllableSet run(double end_rate) {
    SwitchPoint from{leg_.end, end_rate * end_rate, leg_.smooth_intervals.size() - 1, -1, {}};
    for (std::size_t count = 0;; ++count) {
      if (count == max_profiles || limits_.has_reached_evaluation_limit())
        controllable_set_.refusal = format_path_parameter(from.s) + " the search for the law failed";
      const VelocityProfile profile = decelerate_into(from);
      if (!controllable_set_.refusal.empty()) return std::move(controllable_set_);
      if (profile.size() > 1) add_profile(profile, from);
      if (profile.back().s <= leg_.begin) break;
      const double s = profile.back().s;
      const bool has_progressed = from.s - s > min_profile_length * length_;
      const std::optional<SwitchPoint> next =
          find_switch_point(has_progressed ? s : std::max(leg_.begin, s - slope_step_fraction * length_));
      if (!next) break;
      from = *next;
    }
    std::reverse(controllable_set_.profiles.begin(), controllable_set_.profiles.end());
    return std::move(controllable_set_);
  }

 private:
  const SmoothInterval& interval(std::size_t k) const { return leg_.smooth_intervals[k]; }

  void move_to(double s, std::size_t k) { limits_.move_to(s, interval(k).first_panel, interval(k).last_panel); }

  std::size_t interval_before(double s) const {
    std::size_t k = leg_.smooth_intervals.size() - 1;
    while (k > 0 && interval(k).begin >= s) --k;
    return k;
  }

  void add_profile(const VelocityProfile& backwards, const SwitchPoint& from) {
    DecelerationProfile profile{{}, from.zero_inertia};
    const double duration = backwards.back().t;
    for (auto node = backwards.rbegin(); node != backwards.rend(); ++node) {
      profile.points.push_back(*node);
      profile.points.back().t = duration - node->t;
    }
    controllable_set_.profiles.push_back(std::move(profile));
  }

  /// Decelerates into a switch point, backwards until nothing is feasible. Nodes run backwards.
  VelocityProfile decelerate_into(const SwitchPoint& from) {
    for (const double reduction : {0.0, 1e-11, 1e-10, 1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4}) {
      if (reduction == 0 && from.s != leg_.end) continue;
      VelocityProfile profile{{0, from.s, std::sqrt(from.x * (1 - reduction)), 0, -1}};
      if (from.start.is_on_row && reduction < 1e-10) {
        profile.back().v = std::sqrt(from.x);
        if (!step_from_zero_inertia(limits_, interval(from.interval_index), from.start, from.zero_inertia, -1, profile))
          continue;
      }
      integrate_backwards(from.interval_index, profile);
      if (from.s == leg_.end && profile.size() == 1 && controllable_set_.refusal.empty())
        controllable_set_.refusal = format_path_parameter(leg_.end) + " the limits leave no way to brake";
      if (!controllable_set_.refusal.empty() || from.s == leg_.end) return profile;
      if (from.s - profile.back().s > min_profile_length * length_) return profile;
    }
    return {{0, from.s, std::sqrt(from.x), 0, -1}};
  }

  void integrate_backwards(std::size_t k, VelocityProfile& profile) {
    for (;; --k) {
      const double target = interval(k).inner_begin();
      const StepCallback stop_if_diverging = [&](const ProfilePoint&, const ProfilePoint& to) {
        return is_diverging(to, k);
      };
      const IntegrationEnd end =
          integrate_profile(limits_, interval(k), ProfileKind::decelerate, target, stop_if_diverging, profile);
      if (end == IntegrationEnd::unbounded) {
        controllable_set_.refusal =
            format_path_parameter(profile.back().s) +
            " no limit bounds the acceleration: also limit an effort, a force or an acceleration";
        return;
      }
      if (end != IntegrationEnd::reached_target || k == 0 || !is_velocity_feasible(k, profile.back())) return;
    }
  }

  /// Before a zero-inertia point rates may grow without bound.
  bool is_diverging(const ProfilePoint& node, std::size_t k) {
    if (!interval(k).has_zero_inertia_begin ||
        node.s - interval(k).begin > 1e-3 * (interval(k).end - interval(k).begin))
      return false;
    move_to(interval(k).begin, k);
    return limits_.drop_zero_inertia_rows() && node.v * node.v > 16 * limits_.direct_velocity_bound().x;
  }

  /// Whether a rate is feasible on both sides of the breakpoint at which an interval begins.
  bool is_velocity_feasible(std::size_t k, const ProfilePoint& node) {
    const double x = node.v * node.v;
    move_to(interval(k).begin, k);
    if (limits_.drop_zero_inertia_rows() && limits_.bounds(x).is_empty()) return false;
    move_to(interval(k).begin, k - 1);
    limits_.drop_zero_inertia_rows();
    return !limits_.bounds(x).is_empty();
  }

  /// The first point backwards at which the maximum velocity curve cannot be reached along itself: deceleration has to
  /// begin below it.
  std::optional<SwitchPoint> find_switch_point(double from) {
    std::size_t k = interval_before(from);
    if (const bool at_breakpoint = k + 1 < leg_.smooth_intervals.size() && from == interval(k).end; at_breakpoint)
      if (const auto switch_point = switch_point_at_breakpoint(k + 1)) return switch_point;
    double right = from;
    while (true) {
      if (const auto switch_point = switch_point_inside(k, right)) return switch_point;
      if (k == 0) return std::nullopt;
      if (const auto switch_point = switch_point_at_breakpoint(k)) return switch_point;
      right = interval(--k).end;
    }
  }

  /// At the breakpoint between interval k and the one before.
  std::optional<SwitchPoint> switch_point_at_breakpoint(std::size_t k) {
    const double s = interval(k).begin;
    move_to(s, k);
    const bool has_dropped_rows = limits_.drop_zero_inertia_rows();
    const VelocityBound max_velocity = limits_.max_velocity();
    if (has_dropped_rows && limits_.is_dropped(max_velocity.row)) {
      const ZeroInertia::Start start = ZeroInertia::profile_start(limits_, max_velocity.row, max_velocity.x, -1);
      if (start.is_feasible) return SwitchPoint{s, max_velocity.x, k - 1, max_velocity.row, start};
      return std::nullopt;
    }
    move_to(s, k - 1);
    limits_.drop_zero_inertia_rows();
    if (limits_.max_velocity().x > max_velocity.x * (1 + velocity_drop_tolerance))
      return SwitchPoint{s, max_velocity.x, k - 1, -1, {}};
    return std::nullopt;
  }

  /// Whether the maximum velocity curve falls faster than deceleration allows: a profile that decelerates into it then
  /// comes from below.
  bool is_falling_faster_than_deceleration(double s, std::size_t k, double& x) {
    const double step = std::min(slope_step_fraction * length_, (s - interval(k).begin) / 2);
    if (!(step > 0)) return false;
    move_to(s, k);
    x = limits_.max_velocity(x).x;
    if (!std::isfinite(x)) return x = 0, false;
    double min_u = NAN;
    for (double reduction = 1e-12; reduction < 1e-6 && std::isnan(min_u); reduction *= 10)
      if (const AccelerationInterval interval = limits_.bounds(x * (1 - reduction)); !interval.is_empty())
        min_u = interval.lower;
    if (std::isnan(min_u)) return false;
    move_to(s - step, k);
    const double before = limits_.max_velocity(x).x;
    // if both fall equally, the curve itself can be followed
    const double margin = 1e-6 * step * (x / length_ + 2 * std::abs(min_u));
    return x - 2 * min_u * step < before - margin;
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

  AccelerationLimits& limits_;
  const SegmentRange& leg_;
  double length_;
  ControllableSet controllable_set_;
};

}  // namespace

const DecelerationProfile* ControllableSet::profile_at(double s) const {
  const auto next = std::upper_bound(profiles.begin(), profiles.end(), s,
                                     [](double p, const DecelerationProfile& profile) { return p < profile.begin(); });
  if (next == profiles.begin()) return nullptr;
  const DecelerationProfile& profile = *(next - 1);
  return s <= profile.end() ? &profile : nullptr;
}

ControllableSet compute_controllable_set(AccelerationLimits& limits, const SegmentRange& leg, double end_rate) {
  return ControllableSetBuilder(limits, leg).run(end_rate);
}

ProfilePoint interpolate_profile(const VelocityProfile& profile, double s) {
  const auto next = std::upper_bound(profile.begin() + 1, profile.end() - 1, s,
                                     [](double p, const ProfilePoint& node) { return p < node.s; });
  return interpolate_at_parameter(*(next - 1), *next, s);
}

std::string format_path_parameter(double s) {
  char text[64];
  std::snprintf(text, sizeof text, "at %.6g %% of the path", 100 * s);
  return text;
}

namespace {

constexpr double min_progress_fraction = 1e-9;  // of a leg
constexpr double node_time_tolerance = 1e-9;    // of the time so far: nodes closer than this coincide
constexpr double min_velocity_margin = 1e-9;    // of x on the maximum velocity curve: distance at which it is followed
constexpr double max_velocity_margin = 1e-6;
constexpr int max_switches = 500;  // between accelerating, sliding and decelerating

class PhasePlaneSolver {
 public:
  PhasePlaneSolver(AccelerationLimits& limits, const SegmentRange& leg, const ControllableSet& controllable_set,
                   const EndpointRates& rates)
      : limits_(limits), leg_(leg), controllable_set_(controllable_set), rates_(rates) {}

  /// Appends the nodes of the leg. @return why there is no law; empty if there is
  std::string run(std::vector<TimeLawNode>& nodes) {
    nodes_ = &nodes;
    start_ = nodes.empty() ? 0 : nodes.back().t;
    if (const DecelerationProfile* first = controllable_set_.profile_at(leg_.begin); first != nullptr) {
      const double max_start_rate = first->points.front().v;
      if (rates_.start > max_start_rate * (1 + 1e-9)) return "the motion starts too fast to brake within its limits";
    }
    VelocityProfile profile{{0, leg_.begin, rates_.start, 0, -1}};
    int zero_inertia_row = -1;
    for (int iteration = 0; iteration < max_switches; ++iteration) {
      const DecelerationProfile* deceleration_profile = accelerate_to_profile(profile, zero_inertia_row);
      append(profile);
      if (!refusal_.empty()) return refusal_;
      if (deceleration_profile == nullptr) return "the end speed cannot be reached from the start within the limits";
      VelocityProfile remainder = profile_from(*deceleration_profile, profile.back().s);
      zero_inertia_row = deceleration_profile->zero_inertia_row;
      passed_profiles_ = static_cast<std::size_t>(deceleration_profile - controllable_set_.profiles.data()) + 1;
      if (deceleration_profile->end() >= leg_.end) {
        append(remainder);
        return "";
      }
      if (zero_inertia_row < 0) shorten_to_feasible(remainder);
      profile = {{0, remainder.back().s, remainder.back().v, remainder.back().u, remainder.back().row}};
      append(remainder);
    }
    return search_failed(profile.back().s);
  }

 private:
  std::string search_failed(double s) const { return format_path_parameter(s) + " the search for the law failed"; }

  std::size_t interval_from(double s) const {
    std::size_t k = 0;
    while (k + 1 < leg_.smooth_intervals.size() && leg_.smooth_intervals[k].inner_end() <= s) ++k;
    return k;
  }

  /// Continues from the last node until a deceleration profile is met; `profile` then ends with its first point.
  /// @return null if the end of the leg was reached, or if there is a refusal
  const DecelerationProfile* accelerate_to_profile(VelocityProfile& profile, int zero_inertia_row) {
    const DecelerationProfile* crossed_profile = nullptr;
    const StepCallback detect_crossing = [&](const ProfilePoint& from, const ProfilePoint& to) {
      crossed_profile = find_crossing(from, to, profile);
      return crossed_profile != nullptr;
    };
    std::size_t k = interval_from(profile.back().s);
    if (zero_inertia_row >= 0) leave_zero_inertia_point(profile, k, zero_inertia_row);
    ProfileKind kind = ProfileKind::accelerate;
    double velocity_margin = 0;  // margin below the maximum velocity curve, if it is followed
    for (int iteration = 0; iteration < max_switches; ++iteration) {
      const SmoothInterval& interval = leg_.smooth_intervals[k];
      const double s = profile.back().s;
      const DecelerationProfile* next_profile =
          kind == ProfileKind::slide && velocity_margin == 0 ? next_profile_within(interval, s) : nullptr;
      const std::size_t node_count = profile.size();
      const double target = next_profile != nullptr ? next_profile->begin() : interval.inner_end();
      const IntegrationEnd end =
          integrate_profile(limits_, interval, kind, target, detect_crossing, profile, velocity_margin);
      if (crossed_profile != nullptr) return crossed_profile;
      if (end == IntegrationEnd::infeasible_start) {
        refusal_ = format_path_parameter(s) + " the limits leave no way to move off";
        return nullptr;
      }
      if (end == IntegrationEnd::unbounded) {
        refusal_ = format_path_parameter(profile.back().s) +
                   " no limit bounds the acceleration: also limit an effort, a force or an acceleration";
        return nullptr;
      }
      if (end == IntegrationEnd::reached_target && next_profile != nullptr) return next_profile;
      if (end == IntegrationEnd::reached_target) {
        if (++k == leg_.smooth_intervals.size()) return nullptr;
        continue;
      }
      if (end == IntegrationEnd::hit_velocity_bound) {
        kind = ProfileKind::slide;
      } else if (end == IntegrationEnd::left_velocity_bound) {
        kind = ProfileKind::accelerate;
        velocity_margin = 0;
      } else if (end == IntegrationEnd::infeasible && reaches_next_profile(profile, crossed_profile)) {
        return crossed_profile;
      } else if (end == IntegrationEnd::infeasible && kind == ProfileKind::accelerate && velocity_margin == 0) {
        profile.resize(node_count);  // once more, up to just below the maximum velocity curve
        velocity_margin = choose_velocity_margin(interval, s);
      } else if (profile.back().s - s < min_progress_fraction * (leg_.end - leg_.begin)) {
        refusal_ = search_failed(profile.back().s);
        return nullptr;
      }
    }
    refusal_ = search_failed(profile.back().s);
    return nullptr;
  }

  /// Margin below the maximum velocity curve when it is followed: that of the next deceleration profile.
  double choose_velocity_margin(const SmoothInterval& interval, double s) const {
    const DecelerationProfile* next = next_profile_within(interval, s);
    if (next == nullptr) return min_velocity_margin;
    limits_.move_to(next->begin(), interval.first_panel, interval.last_panel);
    const double v = next->points.front().v;
    return std::clamp(2 * (1 - v * v / limits_.max_velocity().x), min_velocity_margin, max_velocity_margin);
  }

  /// Leaves a zero-inertia point along the row that vanishes there.
  void leave_zero_inertia_point(VelocityProfile& profile, std::size_t k, int row) {
    const SmoothInterval& interval = leg_.smooth_intervals[k];
    limits_.move_to(profile.back().s, interval.first_panel, interval.last_panel);
    limits_.drop_zero_inertia_rows();
    const double x = profile.back().v * profile.back().v;
    const ZeroInertia::Start start = ZeroInertia::profile_start(limits_, row, x, 1);
    if (start.is_feasible && start.is_on_row) step_from_zero_inertia(limits_, interval, start, row, 1, profile);
  }

  /// The next deceleration profile, if it begins on an interval.
  const DecelerationProfile* next_profile_within(const SmoothInterval& interval, double s) const {
    for (std::size_t i = passed_profiles_; i < controllable_set_.profiles.size(); ++i)
      if (controllable_set_.profiles[i].begin() > s)
        return controllable_set_.profiles[i].begin() < interval.inner_end() ? &controllable_set_.profiles[i] : nullptr;
    return nullptr;
  }

  /// Whether a slide or a contact ends where the next deceleration profile begins.
  bool reaches_next_profile(VelocityProfile& profile, const DecelerationProfile*& crossed_profile) const {
    for (std::size_t i = passed_profiles_; i < controllable_set_.profiles.size(); ++i) {
      const DecelerationProfile& next = controllable_set_.profiles[i];
      if (next.end() <= profile.back().s) continue;
      const double distance = next.begin() - profile.back().s;
      if (distance > 1e-6 * (leg_.end - leg_.begin)) return false;
      crossed_profile = &next;
      return true;
    }
    return false;
  }

  /// The deceleration profile that a step crosses, or null. Moves the end of the step onto the profile.
  const DecelerationProfile* find_crossing(const ProfilePoint& from, const ProfilePoint& to,
                                           VelocityProfile& profile) const {
    double lower_s = from.s;
    const auto is_above = [&](double s, const DecelerationProfile& deceleration_profile) {
      return interpolate_at_parameter(from, to, s).v > interpolate_profile(deceleration_profile.points, s).v;
    };
    for (std::size_t i = passed_profiles_; i < controllable_set_.profiles.size(); ++i) {
      const DecelerationProfile& deceleration_profile = controllable_set_.profiles[i];
      if (deceleration_profile.end() < from.s) continue;
      if (deceleration_profile.begin() > to.s) break;
      std::vector<double> candidates;
      for (const ProfilePoint& node : deceleration_profile.points)
        if (node.s > from.s && node.s < to.s) candidates.push_back(node.s);
      if (to.s <= deceleration_profile.end()) candidates.push_back(to.s);
      for (const double s : candidates) {
        if (!is_above(s, deceleration_profile)) {
          lower_s = s;
          continue;
        }
        double low = std::max(lower_s, deceleration_profile.begin()), high = s;
        for (int halving = 0; halving < 60 && high - low > 1e-16; ++halving) {
          const double middle = (low + high) / 2;
          (is_above(middle, deceleration_profile) ? high : low) = middle;
        }
        profile.back() = truncate_step(from, to, low);
        return &deceleration_profile;
      }
    }
    return nullptr;
  }

  /// The end of a shortened step.
  static ProfilePoint truncate_step(const ProfilePoint& from, const ProfilePoint& to, double s) {
    ProfilePoint node = interpolate_at_parameter(from, to, s);
    node.row = from.row;
    return node;
  }

  static VelocityProfile profile_from(const DecelerationProfile& deceleration_profile, double s) {
    const double from = std::max(s, deceleration_profile.begin());
    VelocityProfile remainder{interpolate_profile(deceleration_profile.points, from)};
    for (const ProfilePoint& node : deceleration_profile.points)
      if (node.s > from) remainder.push_back(node);
    remainder.front().row = remainder.size() > 1 ? remainder[1].row : -1;
    const double first = remainder.front().t;
    for (ProfilePoint& node : remainder) node.t -= first;
    return remainder;
  }

  /// Shortens a deceleration profile to where acceleration begins: its end or, if nothing is feasible there, just
  /// before.
  void shorten_to_feasible(VelocityProfile& remainder) {
    for (int tries = 0; tries < 6 && remainder.size() > 1; ++tries) {
      ProfilePoint& last = remainder.back();
      const std::size_t k = interval_from(last.s);
      limits_.move_to(last.s, leg_.smooth_intervals[k].first_panel, leg_.smooth_intervals[k].last_panel);
      if (!limits_.bounds(last.v * last.v * (1 - 1e-12)).is_empty()) break;
      const ProfilePoint& before = remainder[remainder.size() - 2];
      const double setback = elementary::pow(10, tries - 8) * (leg_.end - leg_.begin);
      if (last.s - setback <= before.s) {
        remainder.pop_back();
        continue;
      }
      const int row = last.row;
      last = interpolate_at_parameter(before, last, last.s - setback);
      last.row = row;
    }
  }

  void append(const VelocityProfile& profile) {
    for (const ProfilePoint& node : profile) {
      if (&node == &profile.front() && !nodes_->empty()) {
        nodes_->back().u_after = node.u;
        nodes_->back().row_after = profile.size() > 1 ? node.row : nodes_->back().row_after;
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

  AccelerationLimits& limits_;
  const SegmentRange& leg_;
  const ControllableSet& controllable_set_;
  EndpointRates rates_;
  std::size_t passed_profiles_ = 0;  ///< number of deceleration profiles behind
  double start_ = 0;
  std::vector<TimeLawNode>* nodes_ = nullptr;
  std::string refusal_;
};

}  // namespace

TimeOptimalLaw integrate_phase_plane(const PathModel& model, const std::vector<double>& bounds, const SegmentRange& leg,
                                     const EndpointRates& rates) {
  AccelerationLimits limits(model, bounds);
  TimeOptimalLaw law;
  const ControllableSet controllable_set = compute_controllable_set(limits, leg, rates.end);
  law.infeasibility_reason = controllable_set.refusal.empty()
                                 ? PhasePlaneSolver(limits, leg, controllable_set, rates).run(law.nodes)
                                 : controllable_set.refusal;
  return law;
}

}  // namespace balance::time_optimal
