#include "balance/motion/time_optimal/time_optimal_law.hpp"

#include "balance/foundation/numerics/extrema.hpp"
#include "balance/motion/time_optimal/reachability_analysis.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>

namespace balance::time_optimal {
namespace {

constexpr double max_relative_violation = 1e-5;  // of a limit

/// Appends a leg.
void append_segment(const TimeOptimalLaw& leg_law, TimeOptimalLaw& law) {
  const double start = law.nodes.empty() ? 0 : law.duration();
  auto first = leg_law.nodes.begin();
  if (!law.nodes.empty()) {
    law.nodes.back().u_after = first->u_after;
    law.nodes.back().row_after = first->row_after;
    ++first;
  }
  for (; first != leg_law.nodes.end(); ++first) {
    law.nodes.push_back(*first);
    law.nodes.back().t += start;
  }
}

/// By phase-plane integration. If quintics slightly violate a limit between their nodes, solves again with tighter
/// limits.
TimeOptimalLaw solve_by_integration(const PathModel& model, std::vector<double> bounds, const SegmentRange& leg,
                                    const EndpointRates& rates) {
  const TimeOptimalLaw law = integrate_phase_plane(model, bounds, leg, rates);
  if (!law.infeasibility_reason.empty()) return law;
  const double limit_ratio = find_max_limit_ratio(model, bounds, law);
  if (limit_ratio < 1 + limit_violation_tolerance || limit_ratio > 1 + max_relative_violation) return law;
  for (double& bound : bounds) bound /= limit_ratio;
  return integrate_phase_plane(model, bounds, leg, rates);
}

}  // namespace

TimeOptimalLaw find_time_optimal_law(const PathModel& model, const std::vector<double>& bounds,
                                     const EndpointRates& rates) {
  TimeOptimalLaw law;
  law.infeasibility_reason = check_static_feasibility(model, bounds);
  if (!law.infeasibility_reason.empty()) return law;
  const std::vector<SegmentRange> legs = split_into_segments(model);
  for (const SegmentRange& leg : legs) {
    const EndpointRates leg_rates{&leg == &legs.front() ? rates.start : 0, &leg == &legs.back() ? rates.end : 0};
    TimeOptimalLaw leg_law = solve_by_integration(model, bounds, leg, leg_rates);
    if (!leg_law.infeasibility_reason.empty() ||
        !(find_max_limit_ratio(model, bounds, leg_law) < 1 + limit_violation_tolerance)) {
      TimeOptimalLaw reachability_law = solve_by_reachability(model, bounds, leg, leg_rates);
      if (reachability_law.infeasibility_reason.empty()) leg_law = std::move(reachability_law);
    }
    law.infeasibility_reason = leg_law.infeasibility_reason;
    if (!law.infeasibility_reason.empty()) return law;
    append_segment(leg_law, law);
  }
  return law;
}

std::string check_static_feasibility(const PathModel& model, const std::vector<double>& bounds) {
  AccelerationLimits limits(model, bounds);
  double worst_ratio = 1 + 1e-9, worst_s = 0;
  int row = -1;
  for (std::size_t p = 0; p < model.value.panels().size(); ++p) {
    const numerics::Panel& panel = model.value.panels()[p];
    for (int k = 0; k <= 32; ++k) {
      const double s = panel.begin + (panel.end - panel.begin) * k / 32;
      limits.move_to(s, p, p + 1);
      for (std::size_t r = 0; r < bounds.size(); ++r) {
        const double limit_ratio = limits.magnitude(static_cast<int>(r), 0, 0) / bounds[r];
        if (limit_ratio > worst_ratio) worst_ratio = limit_ratio, worst_s = s, row = static_cast<int>(r);
      }
    }
  }
  if (row < 0) return "";
  const PathConstraintRow& violated_row = model.rows[static_cast<std::size_t>(row)];
  const double bound = bounds[static_cast<std::size_t>(row)];
  const char* unit = violated_row.unit.c_str();
  char text[200];
  if (violated_row.centre == 0) {
    std::snprintf(text, sizeof text, " needs %.6g %s at rest, %.6g %s more than its limit", worst_ratio * bound, unit,
                  (worst_ratio - 1) * bound, unit);
  } else {
    limits.move_to(worst_s, 0, model.value.panels().size());
    const double value = limits.static_value(row);
    std::snprintf(text, sizeof text, " needs %.6g %s at rest, %.6g %s %s than its limit", value, unit,
                  (worst_ratio - 1) * bound, unit, value > violated_row.centre ? "more" : "less");
  }
  return format_path_parameter(worst_s) + " " + violated_row.name + text;
}

namespace {

constexpr double duration_tolerance = 1e-10;  // of the duration
constexpr double min_duration_gain = 1e-4;    // of the duration, for fourfold excess: else other limits are active
constexpr double max_relative_peak = 1e12;    // relative to the magnitude at the mean rate
constexpr double constant_part_epsilon =
    1e-9;  // parts of a quantity that do not depend on the motion, relative to those that do

class MinPeakSearch {
 public:
  MinPeakSearch(const PathModel& model, const std::vector<double>& limits, const EndpointRates& rates, double duration)
      : model_(model), limits_(limits), rates_(rates), duration_(duration) {
    for (std::size_t r = limits.size(); r < model.rows.size(); ++r) {
      const PathConstraintRow& row = model.rows[r];
      static_magnitude_ = std::max(static_magnitude_, max_magnitude(row.c, row));
      dynamic_magnitude_ = std::max({dynamic_magnitude_, max_magnitude(row.a, row), max_magnitude(row.b, row)});
      friction_magnitude_ = std::max(friction_magnitude_, max_magnitude(row.d, row));
    }
  }

  MinPeakLaw run() {
    if (!(std::max(dynamic_magnitude_, friction_magnitude_) > 0))
      return make_infeasible("it is zero along this path with any law");
    // only a s'' + b s'²: all peaks scale with 1/T²
    const double rate = 1 / duration_;
    const double size = dynamic_magnitude_ * rate * rate;
    const bool homogeneous = limits_.empty() && static_magnitude_ <= constant_part_epsilon * size &&
                             friction_magnitude_ * rate <= constant_part_epsilon * size && rates_.start == 0 &&
                             rates_.end == 0;
    return homogeneous ? solve_by_scaling(size) : solve_by_bisection(size + friction_magnitude_ * rate);
  }

 private:
  double max_magnitude(int column, const PathConstraintRow& row) const {
    return column < 0 ? 0 : numerics::max_abs(model_.max_magnitude.segment(column, row.count));
  }

  static MinPeakLaw make_infeasible(std::string text) {
    MinPeakLaw result;
    result.law.infeasibility_reason = std::move(text);
    return result;
  }

  MinPeakLaw solve(double peak) const {
    MinPeakLaw result;
    result.peak = peak;
    result.bounds = limits_;
    result.bounds.resize(model_.rows.size(), peak);
    result.law = find_time_optimal_law(model_, result.bounds, rates_);
    return result;
  }

  MinPeakLaw solve_by_scaling(double peak) const {
    MinPeakLaw result = solve(peak);
    if (!result.law.infeasibility_reason.empty()) return result;
    const double ratio = result.law.duration() / duration_;
    result.peak = peak * ratio * ratio;
    return result;
  }

  /// The minimum duration decreases as the peak increases: bracket and bisect the excess of the peak over its value at
  /// rest.
  MinPeakLaw solve_by_bisection(double scale) const {
    double low = 1e-6 * std::max(scale, static_magnitude_), high = scale;
    MinPeakLaw slow = solve(static_magnitude_ + low);
    if (slow.law.infeasibility_reason.empty() && slow.law.duration() <= duration_) {
      if (rates_.start != 0 || rates_.end != 0)
        return make_infeasible("any law that is slow enough has the peak of rest: a longer way at rest is not sought");
      return slow;  // slowing down is allowed: no magnitude exceeds its value at rest
    }
    MinPeakLaw fast = solve(static_magnitude_ + high);
    while (!(fast.law.infeasibility_reason.empty() && fast.law.duration() <= duration_)) {
      low = high;
      high *= 4;
      MinPeakLaw faster = solve(static_magnitude_ + high);
      const bool is_faster = faster.law.infeasibility_reason.empty() &&
                             (!fast.law.infeasibility_reason.empty() ||
                              faster.law.duration() < (1 - min_duration_gain) * fast.law.duration());
      if (!is_faster && (fast.law.infeasibility_reason.empty() || high > max_relative_peak * scale))
        return report_short_duration(fast);
      fast = std::move(faster);
    }
    for (int halving = 0; halving < 100 && high - low > 1e-14 * high; ++halving) {
      const double middle = std::sqrt(low * high);
      MinPeakLaw candidate = solve(static_magnitude_ + middle);
      if (candidate.law.infeasibility_reason.empty() && candidate.law.duration() <= duration_) {
        fast = std::move(candidate);
        high = middle;
        if (duration_ - fast.law.duration() < duration_tolerance * duration_) break;
      } else {
        low = middle;
      }
    }
    return fast;
  }

  MinPeakLaw report_short_duration(const MinPeakLaw& fast) const {
    if (!fast.law.infeasibility_reason.empty()) return make_infeasible(fast.law.infeasibility_reason);
    char text[160];
    std::snprintf(text, sizeof text, "the duration is too short: the other limits alone need %.6g s",
                  fast.law.duration());
    return make_infeasible(text);
  }

  const PathModel& model_;
  const std::vector<double>& limits_;
  EndpointRates rates_;
  double duration_;
  double static_magnitude_ = 0, dynamic_magnitude_ = 0, friction_magnitude_ = 0;
};

}  // namespace

MinPeakLaw find_min_peak_law(const PathModel& model, const std::vector<double>& limits, const EndpointRates& rates,
                             double duration) {
  return MinPeakSearch(model, limits, rates, duration).run();
}

double find_max_limit_ratio_between(const PathModel& model, const std::vector<double>& bounds,
                                    AccelerationLimits& limits, const TimeLawNode& a, const TimeLawNode& b) {
  const ProfilePoint first{a.t, a.s, a.v, a.u_after, -1}, second{b.t, b.s, b.v, b.u_before, -1};
  double max_ratio = 0;
  for (const double fraction : {0.25, 0.5, 0.75}) {
    const ProfilePoint point = interpolate(first, second, a.t + fraction * (b.t - a.t));
    limits.move_to(point.s, 0, model.value.panels().size());
    for (std::size_t r = 0; r < bounds.size(); ++r) {
      const double ratio = limits.magnitude(static_cast<int>(r), point.v * point.v, point.u) / bounds[r];
      max_ratio = std::max(max_ratio, ratio);
    }
  }
  return max_ratio;
}

double find_max_limit_ratio(const PathModel& model, const std::vector<double>& bounds, const TimeOptimalLaw& law) {
  AccelerationLimits limits(model, bounds);
  double max_ratio = 0;
  for (std::size_t k = 0; k + 1 < law.nodes.size(); ++k)
    max_ratio =
        std::max(max_ratio, find_max_limit_ratio_between(model, bounds, limits, law.nodes[k], law.nodes[k + 1]));
  return max_ratio;
}

namespace {

void validate_law_request(const Mechanism& mechanism, const Trajectory& trajectory) {
  const bool fastest = trajectory.law.kind == MotionLawKind::time_optimal;
  if (fastest && trajectory.limits.empty()) throw std::invalid_argument("the law 'fastest' needs limits");
  if (!fastest && trajectory.min_peak_quantity.empty())
    throw std::invalid_argument("the law 'gentlest' needs a quantity whose peak is minimized");
  require_constant_loads(mechanism, fastest ? "the law 'fastest'" : "the law 'gentlest'");
}

/// Rates of the path parameter from the given speeds.
EndpointRates compute_endpoint_rates(const PathModel& model, const Trajectory& trajectory) {
  const auto rate = [](double speed, double scale) {
    if (speed == 0) return 0.0;
    if (!(scale > 0)) throw std::invalid_argument("the path has no direction at an end with a stated speed");
    return speed / scale;
  };
  return {rate(trajectory.start_speed, model.start_speed), rate(trajectory.end_speed, model.end_speed)};
}

}  // namespace

PathLimits make_law_limits(const Mechanism& mechanism, const Trajectory& trajectory) {
  validate_law_request(mechanism, trajectory);
  PathLimits law_limits = collect_limits(mechanism, trajectory);
  if (trajectory.law.kind == MotionLawKind::min_peak)
    for (const results::LimitableQuantity& quantity :
         require_limited_quantities(mechanism, trajectory.min_peak_quantity))
      law_limits.quantities.push_back(quantity);
  return law_limits;
}

MinPeakLaw find_motion_law(const PathModel& model, const PathLimits& law_limits, const Trajectory& trajectory) {
  const EndpointRates rates = compute_endpoint_rates(model, trajectory);
  MinPeakLaw result;
  if (trajectory.law.kind == MotionLawKind::min_peak) {
    result = find_min_peak_law(model, law_limits.half_widths, rates, trajectory.duration);
  } else {
    result.bounds = law_limits.half_widths;
    result.law = find_time_optimal_law(model, law_limits.half_widths, rates);
  }
  if (result.law.infeasibility_reason.empty() &&
      !(find_max_limit_ratio(model, result.bounds, result.law) < 1 + limit_violation_tolerance))
    result.law.infeasibility_reason = "the search for the law failed: its limits would be exceeded";
  return result;
}

}  // namespace balance::time_optimal
