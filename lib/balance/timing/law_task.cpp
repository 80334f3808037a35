#include "balance/timing/law_task.hpp"

#include "balance/timing/kept_limits.hpp"

#include <stdexcept>

namespace balance {
namespace {

void check_request(const Mechanism& mechanism, const Trajectory& trajectory) {
  const bool fastest = trajectory.law.kind == LawKind::fastest;
  if (fastest && trajectory.limits.empty()) throw std::invalid_argument("the law 'fastest' needs limits");
  if (!fastest && trajectory.gentlest_of.empty())
    throw std::invalid_argument("the law 'gentlest' needs a quantity whose peak is to be least");
  refuse_changing_loads(mechanism, fastest ? "the law 'fastest'" : "the law 'gentlest'");
}

/// Rates of the path's parameter from the stated speeds.
EndRates end_rates(const PathModel& model, const Trajectory& trajectory) {
  const auto rate = [](double speed, double scale) {
    if (speed == 0) return 0.0;
    if (!(scale > 0)) throw std::invalid_argument("the path has no direction at an end with a stated speed");
    return speed / scale;
  };
  return {rate(trajectory.start_speed, model.start_speed), rate(trajectory.end_speed, model.end_speed)};
}

}  // namespace

StatedLimits law_task(const Mechanism& mechanism, const Trajectory& trajectory) {
  check_request(mechanism, trajectory);
  StatedLimits task = list_limits(mechanism, trajectory);
  if (trajectory.law.kind == LawKind::gentlest)
    for (const LimitedQuantity& quantity : find_or_throw(mechanism, trajectory.gentlest_of))
      task.quantities.push_back(quantity);
  return task;
}

GentlestLaw find_law(const PathModel& model, const StatedLimits& task, const Trajectory& trajectory) {
  const EndRates rates = end_rates(model, trajectory);
  GentlestLaw found;
  if (trajectory.law.kind == LawKind::gentlest) {
    found = find_gentlest(model, task.bounds, rates, trajectory.duration);
  } else {
    found.bounds = task.bounds;
    found.law = find_fastest(model, task.bounds, rates);
  }
  if (found.law.refusal.empty() && !(worst_load(model, found.bounds, found.law) < 1 + kept))
    found.law.refusal = "the search for the law lost its way: its limits would not be kept";
  return found;
}

}  // namespace balance
