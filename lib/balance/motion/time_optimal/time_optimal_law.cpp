#include "balance/motion/time_optimal/time_optimal_law.hpp"

#include "balance/foundation/numerics/extrema.hpp"
#include "balance/motion/time_optimal/reachability_analysis.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>

namespace balance {
namespace {

constexpr double max_relative_violation = 1e-5;  // of a limit

/// Appends a leg.
void append_segment(const TimeOptimalLaw& part, TimeOptimalLaw& law) {
  const double start = law.nodes.empty() ? 0 : law.duration();
  auto first = part.nodes.begin();
  if (!law.nodes.empty()) {
    law.nodes.back().u_after = first->u_after;
    law.nodes.back().row_after = first->row_after;
    ++first;
  }
  for (; first != part.nodes.end(); ++first) {
    law.nodes.push_back(*first);
    law.nodes.back().t += start;
  }
}

/// By arcs, whose quintics may go a little beyond a limit between their nodes: then within limits that are smaller by that.
TimeOptimalLaw solve_by_integration(const PathModel& model, std::vector<double> bounds, const SegmentRange& leg,
                                    const EndpointRates& rates) {
  const TimeOptimalLaw law = integrate_phase_plane(model, bounds, leg, rates);
  if (!law.infeasibility_reason.empty()) return law;
  const double load = find_max_limit_ratio(model, bounds, law);
  if (load < 1 + limit_violation_tolerance || load > 1 + max_relative_violation) return law;
  for (double& bound : bounds) bound /= load;
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
    const EndpointRates own{&leg == &legs.front() ? rates.start : 0, &leg == &legs.back() ? rates.end : 0};
    TimeOptimalLaw part = solve_by_integration(model, bounds, leg, own);
    if (!part.infeasibility_reason.empty() ||
        !(find_max_limit_ratio(model, bounds, part) < 1 + limit_violation_tolerance)) {
      TimeOptimalLaw swept = solve_by_reachability(model, bounds, leg, own);
      if (swept.infeasibility_reason.empty()) part = std::move(swept);
    }
    law.infeasibility_reason = part.infeasibility_reason;
    if (!law.infeasibility_reason.empty()) return law;
    append_segment(part, law);
  }
  return law;
}

std::string check_static_feasibility(const PathModel& model, const std::vector<double>& bounds) {
  AccelerationLimits allowed(model, bounds);
  double worst = 1 + 1e-9, place = 0;
  int row = -1;
  for (std::size_t p = 0; p < model.value.panels().size(); ++p) {
    const Panel& panel = model.value.panels()[p];
    for (int k = 0; k <= 32; ++k) {
      const double s = panel.begin + (panel.end - panel.begin) * k / 32;
      allowed.move_to(s, p, p + 1);
      for (std::size_t r = 0; r < bounds.size(); ++r) {
        const double load = allowed.magnitude(static_cast<int>(r), 0, 0) / bounds[r];
        if (load > worst) worst = load, place = s, row = static_cast<int>(r);
      }
    }
  }
  if (row < 0) return "";
  const PathConstraintRow& unheld = model.rows[static_cast<std::size_t>(row)];
  const double bound = bounds[static_cast<std::size_t>(row)];
  const char* unit = unheld.unit.c_str();
  char text[200];
  if (unheld.centre == 0) {
    std::snprintf(text, sizeof text, " needs %.6g %s at rest, %.6g %s more than its limit", worst * bound, unit,
                  (worst - 1) * bound, unit);
  } else {
    allowed.move_to(place, 0, model.value.panels().size());
    const double value = allowed.static_value(row);
    std::snprintf(text, sizeof text, " needs %.6g %s at rest, %.6g %s %s than its limit", value, unit,
                  (worst - 1) * bound, unit, value > unheld.centre ? "more" : "less");
  }
  return format_path_parameter(place) + " " + unheld.name + text;
}

namespace {

constexpr double duration_tolerance = 1e-10;  // of the duration
constexpr double min_duration_gain = 1e-4;    // of the duration, by four times the excess: the other limits rule
constexpr double max_relative_peak = 1e12;    // over what the motion is worth at its mean rate
constexpr double constant_part_epsilon =
    1e-9;  // parts of a quantity that do not depend on the motion, of those that do

class MinPeakSearch {
 public:
  MinPeakSearch(const PathModel& model, const std::vector<double>& limits, const EndpointRates& rates, double duration)
      : model_(model), limits_(limits), rates_(rates), duration_(duration) {
    for (std::size_t r = limits.size(); r < model.rows.size(); ++r) {
      const PathConstraintRow& row = model.rows[r];
      at_rest_ = std::max(at_rest_, largest(row.c, row));
      moving_ = std::max({moving_, largest(row.a, row), largest(row.b, row)});
      friction_ = std::max(friction_, largest(row.d, row));
    }
  }

  MinPeakLaw run() {
    if (!(std::max(moving_, friction_) > 0)) return refusal("it is zero along this path by whatever law");
    // a s'' + b s'² alone: by a change of time scale every peak goes with 1/T²
    const double rate = 1 / duration_;
    const double size = moving_ * rate * rate;
    const bool homogeneous = limits_.empty() && at_rest_ <= constant_part_epsilon * size &&
                             friction_ * rate <= constant_part_epsilon * size && rates_.start == 0 && rates_.end == 0;
    return homogeneous ? by_scaling(size) : by_bisection(size + friction_ * rate);
  }

 private:
  double largest(int column, const PathConstraintRow& row) const {
    return column < 0 ? 0 : max_abs(model_.max_magnitude.segment(column, row.count));
  }

  static MinPeakLaw refusal(std::string text) {
    MinPeakLaw none;
    none.law.infeasibility_reason = std::move(text);
    return none;
  }

  MinPeakLaw at(double peak) const {
    MinPeakLaw result;
    result.peak = peak;
    result.bounds = limits_;
    result.bounds.resize(model_.rows.size(), peak);
    result.law = find_time_optimal_law(model_, result.bounds, rates_);
    return result;
  }

  MinPeakLaw by_scaling(double peak) const {
    MinPeakLaw result = at(peak);
    if (!result.law.infeasibility_reason.empty()) return result;
    const double ratio = result.law.duration() / duration_;
    result.peak = peak * ratio * ratio;
    return result;
  }

  /// The least duration falls as the peak rises: bracket, then halve, by the peak's excess over what rest needs.
  MinPeakLaw by_bisection(double scale) const {
    double low = 1e-6 * std::max(scale, at_rest_), high = scale;
    MinPeakLaw slow = at(at_rest_ + low);
    if (slow.law.infeasibility_reason.empty() && slow.law.duration() <= duration_) {
      if (rates_.start != 0 || rates_.end != 0)
        return refusal("any law that is slow enough has the peak of rest: a longer way at rest is not sought");
      return slow;  // its pace may be slackened: nothing grows beyond what rest needs
    }
    MinPeakLaw fast = at(at_rest_ + high);
    while (!(fast.law.infeasibility_reason.empty() && fast.law.duration() <= duration_)) {
      low = high;
      high *= 4;
      MinPeakLaw faster = at(at_rest_ + high);
      const bool gains = faster.law.infeasibility_reason.empty() &&
                         (!fast.law.infeasibility_reason.empty() ||
                          faster.law.duration() < (1 - min_duration_gain) * fast.law.duration());
      if (!gains && (fast.law.infeasibility_reason.empty() || high > max_relative_peak * scale))
        return report_short_duration(fast);
      fast = std::move(faster);
    }
    for (int halving = 0; halving < 100 && high - low > 1e-14 * high; ++halving) {
      const double middle = std::sqrt(low * high);
      MinPeakLaw tried = at(at_rest_ + middle);
      if (tried.law.infeasibility_reason.empty() && tried.law.duration() <= duration_) {
        fast = std::move(tried);
        high = middle;
        if (duration_ - fast.law.duration() < duration_tolerance * duration_) break;
      } else {
        low = middle;
      }
    }
    return fast;
  }

  MinPeakLaw report_short_duration(const MinPeakLaw& fast) const {
    if (!fast.law.infeasibility_reason.empty()) return refusal(fast.law.infeasibility_reason);
    char text[160];
    std::snprintf(text, sizeof text, "the duration is too short: the other limits alone need %.6g s",
                  fast.law.duration());
    return refusal(text);
  }

  const PathModel& model_;
  const std::vector<double>& limits_;
  EndpointRates rates_;
  double duration_;
  double at_rest_ = 0, moving_ = 0, friction_ = 0;
};

}  // namespace

MinPeakLaw find_min_peak_law(const PathModel& model, const std::vector<double>& limits, const EndpointRates& rates,
                             double duration) {
  return MinPeakSearch(model, limits, rates, duration).run();
}

double find_max_limit_ratio_between(const PathModel& model, const std::vector<double>& bounds,
                                    AccelerationLimits& allowed, const TimeLawNode& a, const TimeLawNode& b) {
  const ProfilePoint first{a.t, a.s, a.v, a.u_after, -1}, second{b.t, b.s, b.v, b.u_before, -1};
  double worst = 0;
  for (const double part : {0.25, 0.5, 0.75}) {
    const ProfilePoint here = interpolate(first, second, a.t + part * (b.t - a.t));
    allowed.move_to(here.s, 0, model.value.panels().size());
    for (std::size_t r = 0; r < bounds.size(); ++r) {
      const double load = allowed.magnitude(static_cast<int>(r), here.v * here.v, here.u) / bounds[r];
      worst = std::max(worst, load);
    }
  }
  return worst;
}

double find_max_limit_ratio(const PathModel& model, const std::vector<double>& bounds, const TimeOptimalLaw& law) {
  AccelerationLimits allowed(model, bounds);
  double worst = 0;
  for (std::size_t k = 0; k + 1 < law.nodes.size(); ++k)
    worst = std::max(worst, find_max_limit_ratio_between(model, bounds, allowed, law.nodes[k], law.nodes[k + 1]));
  return worst;
}

namespace {

void validate_law_request(const Mechanism& mechanism, const Trajectory& trajectory) {
  const bool fastest = trajectory.law.kind == MotionLawKind::time_optimal;
  if (fastest && trajectory.limits.empty()) throw std::invalid_argument("the law 'fastest' needs limits");
  if (!fastest && trajectory.min_peak_quantity.empty())
    throw std::invalid_argument("the law 'gentlest' needs a quantity whose peak is to be least");
  require_constant_loads(mechanism, fastest ? "the law 'fastest'" : "the law 'gentlest'");
}

/// Rates of the path's parameter from the stated speeds.
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
  PathLimits task = collect_limits(mechanism, trajectory);
  if (trajectory.law.kind == MotionLawKind::min_peak)
    for (const LimitableQuantity& quantity : require_limited_quantities(mechanism, trajectory.min_peak_quantity))
      task.quantities.push_back(quantity);
  return task;
}

MinPeakLaw find_motion_law(const PathModel& model, const PathLimits& task, const Trajectory& trajectory) {
  const EndpointRates rates = compute_endpoint_rates(model, trajectory);
  MinPeakLaw found;
  if (trajectory.law.kind == MotionLawKind::min_peak) {
    found = find_min_peak_law(model, task.half_widths, rates, trajectory.duration);
  } else {
    found.bounds = task.half_widths;
    found.law = find_time_optimal_law(model, task.half_widths, rates);
  }
  if (found.law.infeasibility_reason.empty() &&
      !(find_max_limit_ratio(model, found.bounds, found.law) < 1 + limit_violation_tolerance))
    found.law.infeasibility_reason = "the search for the law lost its way: its limits would not be kept";
  return found;
}

}  // namespace balance
