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
constexpr double switch_tolerance = 1e-4;

MotionOutcome make_infeasible_outcome(const std::string& reason) {
  return {MotionStatus::limits_not_held, 0, reason, {}};
}

bool is_switch(const TimeLawNode& node) {
  return std::abs(node.u_after - node.u_before) > switch_tolerance * (std::abs(node.u_after) + std::abs(node.u_before));
}

OptimisedLaw describe_law(const PathModel& model, const TimeOptimalLaw& law, double stretched) {
  OptimisedLaw found;
  found.duration = law.duration() * stretched;
  for (std::size_t k = 0; k + 1 < law.nodes.size(); ++k) {
    const TimeLawNode &a = law.nodes[k], &b = law.nodes[k + 1];
    const double begin = a.t * stretched, end = b.t * stretched;
    const bool jump = k > 0 && is_switch(a);
    if (jump) found.switch_times.push_back(begin);
    const std::string limit = a.row_after < 0 ? "" : model.rows[static_cast<std::size_t>(a.row_after)].name;
    if (!jump && !found.active_limits.empty() && found.active_limits.back().limit == limit) {
      found.active_limits.back().end = end;
      found.active_limits.back().path_end = b.s;
    } else {
      found.active_limits.push_back({begin, end, a.s, b.s, limit});
    }
  }
  return found;
}

MotionLaw to_motion_law(MotionLawKind kind, const TimeOptimalLaw& found) {
  MotionLaw law{.kind = kind};
  const double duration = found.duration();
  for (const TimeLawNode& node : found.nodes) {
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
void add_mvc_of_limits(const Mechanism& mechanism, ResolvedTrajectory& timed) {
  if (timed.trajectory.limits.empty()) return;
  const PathLimits limits = collect_limits(mechanism, timed.trajectory);
  const PathModel model = build_limited_path_model(mechanism, timed.trajectory, limits);
  timed.outcome = model.outcome;
  if (model.outcome.status == MotionStatus::done)
    add_maximum_velocity_curve(model, limits.half_widths, timed.phase_plane);
}

bool has_momentum_task(const Trajectory& trajectory) {
  return std::any_of(trajectory.secondary_tasks.begin(), trajectory.secondary_tasks.end(),
                     [](const SecondaryTask& course) { return std::holds_alternative<MomentumTask>(course.kind); });
}

/// The law along a path that keeps the angular momentum.
void apply_constant_momentum_law(const Mechanism& mechanism, ResolvedTrajectory& timed) {
  if (mechanism.space != SpaceKind::planar)
    throw std::invalid_argument("the law 'steady-momentum' is one for planar mechanisms");
  Trajectory& trajectory = timed.trajectory;
  const PathModel model =
      build_path_model(mechanism, trajectory, require_limited_quantities(mechanism, "shaking_moment"));
  timed.outcome = model.outcome;
  if (model.outcome.status != MotionStatus::done) return;
  ConstantMomentumLaw steady = find_constant_momentum_law(model, trajectory.duration);
  if (!steady.refusal.empty()) {
    timed.outcome = make_infeasible_outcome(steady.refusal);
    return;
  }
  trajectory.law = std::move(steady.law);
  timed.optimised_law.emplace();
  timed.optimised_law->duration = trajectory.duration;
  timed.optimised_law->momentum = steady.momentum;
}

/// The fastest or the gentlest law.
void apply_optimised_law(const Mechanism& mechanism, ResolvedTrajectory& timed) {
  const Trajectory trajectory = timed.trajectory;
  const MotionLawKind kind = trajectory.law.kind;
  const PathLimits task = make_law_limits(mechanism, trajectory);
  const PathModel model = build_limited_path_model(mechanism, trajectory, task);
  timed.outcome = model.outcome;
  if (model.outcome.status != MotionStatus::done) return;
  const MinPeakLaw gentlest = find_motion_law(model, task, trajectory);
  const TimeOptimalLaw& law = gentlest.law;
  if (!law.infeasibility_reason.empty()) {
    timed.outcome = make_infeasible_outcome(law.infeasibility_reason);
    return;
  }
  timed.trajectory.law = to_motion_law(kind, law);
  if (kind == MotionLawKind::time_optimal) timed.trajectory.duration = law.duration();
  timed.optimised_law = describe_law(model, law, timed.trajectory.duration / law.duration());
  if (kind == MotionLawKind::min_peak) {
    timed.optimised_law->objective = trajectory.min_peak_quantity;
    timed.optimised_law->objective_value = gentlest.peak;
    timed.optimised_law->unit = model.rows[task.half_widths.size()].unit;
  }
  std::vector<double> bounds = task.half_widths;
  bounds.resize(model.rows.size(), gentlest.peak);
  add_maximum_velocity_curve(model, bounds, timed.phase_plane);
}

}  // namespace

ResolvedTrajectory resolve_trajectory(const Mechanism& mechanism, const Trajectory& stated) {
  ResolvedTrajectory timed{{MotionStatus::done, 0, "", {}}, stated, std::nullopt, std::nullopt, {}};
  if (has_velocity_constraints(mechanism) && (stated.corridor || has_momentum_task(stated)))
    throw std::invalid_argument("where rates are bound, no way can be found in a corridor or for a kept momentum");
  timed.outcome = optimise_corridor_path(mechanism, timed.trajectory, timed.corridor);
  if (timed.outcome.status != MotionStatus::done) return timed;
  timed.outcome = solve_momentum_tasks(mechanism, timed.trajectory);
  if (timed.outcome.status != MotionStatus::done) return timed;
  const MotionLawKind kind = stated.law.kind;
  if (is_mechanism_dependent(kind) && !timed.trajectory.law.nodes.empty()) return timed;
  if (kind == MotionLawKind::time_optimal || kind == MotionLawKind::min_peak) {
    apply_optimised_law(mechanism, timed);
    return timed;
  }
  if (kind == MotionLawKind::constant_momentum) apply_constant_momentum_law(mechanism, timed);
  if (timed.outcome.status == MotionStatus::done) add_mvc_of_limits(mechanism, timed);
  return timed;
}

}  // namespace balance
