#include "balance/timing/time_law.hpp"

#include "balance/timing/fastest.hpp"
#include "balance/timing/gentlest.hpp"
#include "balance/timing/kept_momentum.hpp"
#include "balance/timing/steady_momentum.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>

namespace balance {
namespace {

/// Limits are kept to this part of them.
constexpr double kept = 1e-6;

/// Jumps of s'' below this part of its size are no switches.
constexpr double least_switch = 1e-4;

MotionOutcome refused(const std::string& reason) { return {MotionStatus::limits_not_held, 0, reason, {}}; }

std::vector<LimitedQuantity> find_or_throw(const Mechanism& mechanism, const std::string& name) {
  std::vector<LimitedQuantity> found = find_limited(mechanism, name);
  if (found.empty()) throw std::invalid_argument("no law of motion can limit '" + name + "' of this mechanism");
  return found;
}

void check_request(const Mechanism& mechanism, const Trajectory& trajectory) {
  if (trajectory.law.kind == LawKind::steady_momentum) {
    if (mechanism.space != SpaceKind::planar)
      throw std::invalid_argument("the law 'steady-momentum' is one for planar mechanisms");
    return;
  }
  const bool fastest = trajectory.law.kind == LawKind::fastest;
  if (fastest && trajectory.limits.empty()) throw std::invalid_argument("the law 'fastest' needs limits");
  if (!fastest && trajectory.gentlest_of.empty())
    throw std::invalid_argument("the law 'gentlest' needs a quantity whose peak is to be least");
  for (const MotionLimit& limit : trajectory.limits)
    if (!(limit.bound > 0) || !std::isfinite(limit.bound))
      throw std::invalid_argument("the limit of " + limit.quantity + " must be positive");
  for (const Load& load : mechanism.loads)
    for (std::size_t k = 1; k < load.force.size(); ++k)
      if (load.force[k] != load.force[0] || load.moment[k] != load.moment[0])
        throw std::invalid_argument("the law '" + std::string(fastest ? "fastest" : "gentlest") +
                                    "' cannot be found under the load " + load.name + ", which changes with time");
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

/// The law between its nodes against every limit. @return the worst load, as a part of its bound
double worst_load(const PathModel& model, const std::vector<double>& bounds, const FastestLaw& law) {
  Allowed allowed(model, bounds);
  double worst = 0;
  const std::size_t panels = model.value.panels().size();
  for (std::size_t k = 0; k + 1 < law.nodes.size(); ++k) {
    const TimedNode &a = law.nodes[k], &b = law.nodes[k + 1];
    const ArcNode first{a.t, a.s, a.v, a.u_after, -1}, second{b.t, b.s, b.v, b.u_before, -1};
    for (const double part : {0.25, 0.5, 0.75}) {
      const ArcNode here = between(first, second, a.t + part * (b.t - a.t));
      allowed.go(here.s, 0, panels);
      for (std::size_t r = 0; r < bounds.size(); ++r) {
        const double load = allowed.magnitude(static_cast<int>(r), here.v * here.v, here.u) / bounds[r];
        worst = std::max(worst, load);
      }
    }
  }
  return worst;
}

bool is_switch(const TimedNode& node) {
  return std::abs(node.u_after - node.u_before) > least_switch * (std::abs(node.u_after) + std::abs(node.u_before));
}

FoundLaw tell(const PathModel& model, const FastestLaw& law, double stretched) {
  FoundLaw found;
  found.duration = law.duration() * stretched;
  for (std::size_t k = 0; k + 1 < law.nodes.size(); ++k) {
    const TimedNode &a = law.nodes[k], &b = law.nodes[k + 1];
    const double begin = a.t * stretched, end = b.t * stretched;
    const bool jump = k > 0 && is_switch(a);
    if (jump) found.switches.push_back(begin);
    const std::string limit = a.row_after < 0 ? "" : model.rows[static_cast<std::size_t>(a.row_after)].name;
    if (!jump && !found.stretches.empty() && found.stretches.back().limit == limit) {
      found.stretches.back().end = end;
      found.stretches.back().to = b.s;
    } else {
      found.stretches.push_back({begin, end, a.s, b.s, limit});
    }
  }
  return found;
}

Law as_law(LawKind kind, const FastestLaw& found) {
  Law law{.kind = kind};
  const double duration = found.duration();
  for (const TimedNode& node : found.nodes) {
    const bool jump = is_switch(node);
    const double mean = (node.u_before + node.u_after) / 2;
    const double before = jump ? node.u_before : mean, after = jump ? node.u_after : mean;
    law.nodes.push_back(
        {node.t / duration, node.s, node.v * duration, before * duration * duration, after * duration * duration});
  }
  law.nodes.back().tau = 1;
  return law;
}

/// Limits as given, several on one quantity all kept.
void list_limits(const Mechanism& mechanism, const Trajectory& trajectory, std::vector<LimitedQuantity>& quantities,
                 std::vector<double>& bounds) {
  for (const MotionLimit& limit : trajectory.limits)
    for (const LimitedQuantity& quantity : find_or_throw(mechanism, limit.quantity)) {
      quantities.push_back(quantity);
      bounds.push_back(limit.bound);
    }
}

/// The law along a path that keeps the angular momentum.
void keep_steady(const Mechanism& mechanism, TimedTrajectory& timed) {
  Trajectory& trajectory = timed.trajectory;
  const PathModel model = model_path(mechanism, trajectory, find_or_throw(mechanism, "shaking_moment"));
  timed.outcome = model.outcome;
  if (model.outcome.status != MotionStatus::done) return;
  SteadyLaw steady = find_steady_momentum(model, trajectory.duration);
  if (!steady.refusal.empty()) {
    timed.outcome = refused(steady.refusal);
    return;
  }
  trajectory.law = std::move(steady.law);
  timed.found.emplace();
  timed.found->duration = trajectory.duration;
  timed.found->momentum = steady.momentum;
}

}  // namespace

TimedTrajectory time_law(const Mechanism& mechanism, const Trajectory& stated) {
  TimedTrajectory timed{{MotionStatus::done, 0, "", {}}, stated, std::nullopt};
  timed.outcome = keep_momentum(mechanism, timed.trajectory);
  if (timed.outcome.status != MotionStatus::done) return timed;
  const Trajectory trajectory = timed.trajectory;
  const LawKind kind = trajectory.law.kind;
  if (!is_searched(kind) || !trajectory.law.nodes.empty()) return timed;
  check_request(mechanism, trajectory);
  if (kind == LawKind::steady_momentum) {
    keep_steady(mechanism, timed);
    return timed;
  }
  std::vector<LimitedQuantity> quantities;
  std::vector<double> bounds;
  list_limits(mechanism, trajectory, quantities, bounds);
  const std::size_t limits = bounds.size();
  if (kind == LawKind::gentlest)
    for (const LimitedQuantity& quantity : find_or_throw(mechanism, trajectory.gentlest_of))
      quantities.push_back(quantity);
  const PathModel model = model_path(mechanism, trajectory, quantities);
  timed.outcome = model.outcome;
  if (model.outcome.status != MotionStatus::done) return timed;
  const EndRates rates = end_rates(model, trajectory);
  GentlestLaw gentlest;
  if (kind == LawKind::gentlest)
    gentlest = find_gentlest(model, bounds, rates, trajectory.duration);
  else
    gentlest.law = find_fastest(model, bounds, rates);
  const FastestLaw& law = gentlest.law;
  if (law.refusal.empty() && !(worst_load(model, kind == LawKind::gentlest ? gentlest.bounds : bounds, law) < 1 + kept))
    gentlest.law.refusal = "the search for the law lost its way: its limits would not be kept";
  if (!law.refusal.empty()) {
    timed.outcome = refused(law.refusal);
    return timed;
  }
  timed.trajectory.law = as_law(kind, law);
  if (kind == LawKind::fastest) timed.trajectory.duration = law.duration();
  timed.found = tell(model, law, timed.trajectory.duration / law.duration());
  if (kind == LawKind::gentlest) {
    timed.found->of = trajectory.gentlest_of;
    timed.found->peak = gentlest.peak;
    timed.found->unit = model.rows[limits].unit;
  }
  return timed;
}

}  // namespace balance
