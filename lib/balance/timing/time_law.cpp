#include "balance/timing/time_law.hpp"

#include "balance/timing/ceiling_curve.hpp"
#include "balance/timing/corridor.hpp"
#include "balance/timing/kept_momentum.hpp"
#include "balance/timing/law_task.hpp"
#include "balance/timing/steady_momentum.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>

namespace balance {
namespace {

/// Jumps of s'' below this part of its size are no switches.
constexpr double least_switch = 1e-4;

MotionOutcome refused(const std::string& reason) { return {MotionStatus::limits_not_held, 0, reason, {}}; }

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

/// What limits would allow beside a law that does not ask for them.
void tell_ceiling(const Mechanism& mechanism, TimedTrajectory& timed) {
  if (timed.trajectory.limits.empty()) return;
  const StatedLimits limits = list_limits(mechanism, timed.trajectory);
  const PathModel model = model_limits(mechanism, timed.trajectory, limits);
  timed.outcome = model.outcome;
  if (model.outcome.status == MotionStatus::done) add_ceiling(model, limits.bounds, timed.phase_plane);
}

bool depends_on_momentum(const Trajectory& trajectory) {
  return std::any_of(trajectory.courses.begin(), trajectory.courses.end(),
                     [](const Course& course) { return std::holds_alternative<KeptMomentum>(course.kind); });
}

/// The law along a path that keeps the angular momentum.
void keep_steady(const Mechanism& mechanism, TimedTrajectory& timed) {
  if (mechanism.space != SpaceKind::planar)
    throw std::invalid_argument("the law 'steady-momentum' is one for planar mechanisms");
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

/// The fastest or the gentlest law.
void search(const Mechanism& mechanism, TimedTrajectory& timed) {
  const Trajectory trajectory = timed.trajectory;
  const LawKind kind = trajectory.law.kind;
  const StatedLimits task = law_task(mechanism, trajectory);
  const PathModel model = model_limits(mechanism, trajectory, task);
  timed.outcome = model.outcome;
  if (model.outcome.status != MotionStatus::done) return;
  const GentlestLaw gentlest = find_law(model, task, trajectory);
  const FastestLaw& law = gentlest.law;
  if (!law.refusal.empty()) {
    timed.outcome = refused(law.refusal);
    return;
  }
  timed.trajectory.law = as_law(kind, law);
  if (kind == LawKind::fastest) timed.trajectory.duration = law.duration();
  timed.found = tell(model, law, timed.trajectory.duration / law.duration());
  if (kind == LawKind::gentlest) {
    timed.found->of = trajectory.gentlest_of;
    timed.found->peak = gentlest.peak;
    timed.found->unit = model.rows[task.bounds.size()].unit;
  }
  std::vector<double> bounds = task.bounds;
  bounds.resize(model.rows.size(), gentlest.peak);
  add_ceiling(model, bounds, timed.phase_plane);
}

}  // namespace

TimedTrajectory time_law(const Mechanism& mechanism, const Trajectory& stated) {
  TimedTrajectory timed{{MotionStatus::done, 0, "", {}}, stated, std::nullopt, std::nullopt, {}};
  if (binds_rates(mechanism) && (stated.corridor || depends_on_momentum(stated)))
    throw std::invalid_argument("where rates are bound, no way can be found in a corridor or for a kept momentum");
  timed.outcome = find_corridor(mechanism, timed.trajectory, timed.corridor);
  if (timed.outcome.status != MotionStatus::done) return timed;
  timed.outcome = keep_momentum(mechanism, timed.trajectory);
  if (timed.outcome.status != MotionStatus::done) return timed;
  const LawKind kind = stated.law.kind;
  if (is_searched(kind) && !timed.trajectory.law.nodes.empty()) return timed;
  if (kind == LawKind::fastest || kind == LawKind::gentlest) {
    search(mechanism, timed);
    return timed;
  }
  if (kind == LawKind::steady_momentum) keep_steady(mechanism, timed);
  if (timed.outcome.status == MotionStatus::done) tell_ceiling(mechanism, timed);
  return timed;
}

}  // namespace balance
