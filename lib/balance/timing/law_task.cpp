#include "balance/timing/law_task.hpp"

#include "balance/timing/kept_limits.hpp"

#include <stdexcept>

namespace balance {
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
