#include "balance/motion/time_optimal/resolve_trajectory.hpp"

#include "balance/mechanics/trajectory/optimised_law.hpp"
#include "balance/motion/time_optimal/acceleration_limits.hpp"
#include "balance/motion/time_optimal/corridor_search.hpp"
#include "balance/motion/time_optimal/momentum_task.hpp"
#include "balance/motion/time_optimal/path_model.hpp"
#include "balance/motion/time_optimal/time_optimal_law.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>
#include <string>
#include <vector>

namespace balance::time_optimal {

// Maximum velocity curve and constant momentum.

/// Fills the maximum velocity curve of a phase plane.
/// @param bounds one per row of the model
void add_maximum_velocity_curve(const PathModel& model, const std::vector<double>& bounds,
                                trajectory::PhasePlane& plane);

/// Law that traverses a path with constant angular momentum.
struct ConstantMomentumLaw {
  MotionLaw law;
  double momentum = 0;  ///< about the trajectory's reference point [N m s]
  double min_momentum_per_rate = 0,
         max_momentum_per_rate = 0;  ///< range of the angular momentum per rate of the path parameter [kg m^2]
  std::string refusal;               ///< why there is none; empty if there is
};

/// If h = g(s) s' is constant, the shaking moment vanishes: s' = h / g, s'' = −h² g' / g³, h = ∫ g ds / T. The law
/// exists if g does not change its sign.
/// @param model of a planar mechanism whose first row is the shaking moment
/// @param duration T [s]
ConstantMomentumLaw find_constant_momentum_law(const PathModel& model, double duration);

namespace {

constexpr double curve_points = 400;        // per path
constexpr double min_points_per_panel = 4;  // per panel

}  // namespace

void add_maximum_velocity_curve(const PathModel& model, const std::vector<double>& bounds,
                                trajectory::PhasePlane& plane) {
  AccelerationLimits limits(model, bounds);
  std::vector<double> path_parameters, path_rates;
  double guess = 0;
  for (std::size_t p = 0; p < model.value.panels().size(); ++p) {
    const numerics::Panel& panel = model.value.panels()[p];
    const double width = panel.end - panel.begin;
    const int intervals = static_cast<int>(std::max(min_points_per_panel, std::ceil(curve_points * width)));
    for (int k = 0; k <= intervals; ++k) {
      const double s = k == intervals ? panel.end : panel.begin + width * k / intervals;
      limits.move_to(s, p, p + 1);
      limits.drop_zero_inertia_rows();
      const VelocityBound max_velocity = limits.max_velocity(guess);
      guess = std::isfinite(max_velocity.x) ? max_velocity.x : 0;
      if (!path_parameters.empty() && s == path_parameters.back() && std::sqrt(max_velocity.x) == path_rates.back())
        continue;
      path_parameters.push_back(s);
      path_rates.push_back(std::sqrt(max_velocity.x));
    }
  }
  plane.mvc_path_parameter =
      Eigen::Map<const VectorX>(path_parameters.data(), static_cast<Eigen::Index>(path_parameters.size()));
  plane.mvc_path_rate = Eigen::Map<const VectorX>(path_rates.data(), static_cast<Eigen::Index>(path_rates.size()));
}

namespace {

constexpr int nodes_per_panel = 64;             // between nodes the law is a quintic
constexpr double min_momentum_fraction = 1e-6;  // of the maximum momentum per rate: below it, the law is unbounded

/// @param speed of the driven point at the start, per rate of the path parameter
std::string explain_sign_change(double s, const ConstantMomentumLaw& law, double speed) {
  const double unit = speed > 0 ? speed : 1;
  char text[320];
  std::snprintf(text, sizeof text,
                "at %.6g %% of the path the angular momentum cannot be kept: per unit of the drive's rate it goes "
                "through zero (it ranges from %.8g to %.8g in SI units)",
                100 * s, law.min_momentum_per_rate / unit, law.max_momentum_per_rate / unit);
  return text;
}

/// @return location of the minimum of a mostly positive function, or of the maximum of a mostly negative one
double find_momentum_range(const numerics::PiecewiseChebyshevSeries& g, ConstantMomentumLaw& law) {
  std::vector<double> candidates = find_roots(g.derivative(), 0);
  for (const numerics::Panel& panel : g.panels()) candidates.insert(candidates.end(), {panel.begin, panel.end});
  law.min_momentum_per_rate = INFINITY, law.max_momentum_per_rate = -INFINITY;
  double min_location = 0, max_location = 0, value = 0;
  for (const double s : candidates) {
    g.evaluate(g.find_panel(s, 0, g.panels().size()), s, &value);
    if (value < law.min_momentum_per_rate) law.min_momentum_per_rate = value, min_location = s;
    if (value > law.max_momentum_per_rate) law.max_momentum_per_rate = value, max_location = s;
  }
  return law.max_momentum_per_rate > -law.min_momentum_per_rate ? min_location : max_location;
}

}  // namespace

ConstantMomentumLaw find_constant_momentum_law(const PathModel& model, double duration) {
  ConstantMomentumLaw result;
  result.law.kind = MotionLawKind::constant_momentum;
  const PathConstraintRow& row = model.rows.front();
  const int column = row.a;
  if (column < 0) {
    result.refusal = "the mechanism has no angular momentum on this path that could be kept";
    return result;
  }
  std::vector<numerics::Panel> panels = model.value.panels();
  for (numerics::Panel& panel : panels) panel.coefficients = Samples(panel.coefficients.col(column));
  const numerics::PiecewiseChebyshevSeries g(std::move(panels)), integral_of_g = g.integral();
  VectorX columns(model.value.function_count());
  const double critical_s = find_momentum_range(g, result);
  if (!(result.min_momentum_per_rate * result.max_momentum_per_rate > 0) ||
      std::min(std::abs(result.min_momentum_per_rate), std::abs(result.max_momentum_per_rate)) <
          min_momentum_fraction * std::max(-result.min_momentum_per_rate, result.max_momentum_per_rate)) {
    result.refusal = explain_sign_change(critical_s, result, model.start_speed);
    return result;
  }
  double total = 0;
  integral_of_g.evaluate(integral_of_g.panels().size() - 1, 1, &total);
  result.momentum = total / duration;
  for (std::size_t p = 0; p < g.panels().size(); ++p)
    for (int k = p == 0 ? 0 : 1; k <= nodes_per_panel; ++k) {
      const numerics::Panel& panel = g.panels()[p];
      const double s = k == nodes_per_panel ? panel.end : panel.begin + (panel.end - panel.begin) * k / nodes_per_panel;
      double partial = 0;
      model.value.evaluate(p, s, columns.data());
      integral_of_g.evaluate(p, s, &partial);
      const double g_value = columns[column],
                   g_slope = row.b < 0 ? 0 : columns[row.b];  // g' is the moment's coefficient of s'²
      const double rate = total / g_value, second = -rate * rate * g_slope / g_value;
      result.law.nodes.push_back({partial / total, s, rate, second, second});
    }
  result.law.nodes.back().tau = 1;
  return result;
}

namespace {

/// Jumps of s'' below this fraction of its magnitude are not switches.
constexpr double switch_tolerance = 1e-4;

MotionOutcome make_infeasible_outcome(const std::string& reason) {
  return {MotionStatus::limits_not_held, 0, reason, {}};
}

bool is_switch(const TimeLawNode& node) {
  return std::abs(node.u_after - node.u_before) > switch_tolerance * (std::abs(node.u_after) + std::abs(node.u_before));
}

trajectory::OptimisedLaw describe_law(const PathModel& model, const TimeOptimalLaw& law, double time_scale) {
  trajectory::OptimisedLaw result;
  result.duration = law.duration() * time_scale;
  for (std::size_t k = 0; k + 1 < law.nodes.size(); ++k) {
    const TimeLawNode &a = law.nodes[k], &b = law.nodes[k + 1];
    const double begin = a.t * time_scale, end = b.t * time_scale;
    const bool jump = k > 0 && is_switch(a);
    if (jump) result.switch_times.push_back(begin);
    const std::string limit = a.row_after < 0 ? "" : model.rows[static_cast<std::size_t>(a.row_after)].name;
    if (!jump && !result.active_limits.empty() && result.active_limits.back().limit == limit) {
      result.active_limits.back().end = end;
      result.active_limits.back().path_end = b.s;
    } else {
      result.active_limits.push_back({begin, end, a.s, b.s, limit});
    }
  }
  return result;
}

MotionLaw to_motion_law(MotionLawKind kind, const TimeOptimalLaw& optimal_law) {
  MotionLaw law{.kind = kind};
  const double duration = optimal_law.duration();
  for (const TimeLawNode& node : optimal_law.nodes) {
    const bool jump = is_switch(node);
    const double mean = (node.u_before + node.u_after) / 2;
    const double before = jump ? node.u_before : mean, after = jump ? node.u_after : mean;
    law.nodes.push_back(
        {node.t / duration, node.s, node.v * duration, before * duration * duration, after * duration * duration});
  }
  law.nodes.back().tau = 1;
  return law;
}

/// Adds the maximum velocity curve of limits that the law does not use.
void add_mvc_of_limits(const Mechanism& mechanism, ResolvedTrajectory& resolved) {
  if (resolved.trajectory.limits.empty()) return;
  const PathLimits limits = collect_limits(mechanism, resolved.trajectory);
  const PathModel model = build_limited_path_model(mechanism, resolved.trajectory, limits);
  resolved.outcome = model.outcome;
  if (model.outcome.status == MotionStatus::done)
    add_maximum_velocity_curve(model, limits.half_widths, resolved.phase_plane);
}

bool has_momentum_task(const Trajectory& trajectory) {
  return std::any_of(trajectory.secondary_tasks.begin(), trajectory.secondary_tasks.end(),
                     [](const trajectory::SecondaryTask& task) {
                       return std::holds_alternative<trajectory::MomentumTask>(task.kind);
                     });
}

/// Finds the law along a path with constant angular momentum.
void apply_constant_momentum_law(const Mechanism& mechanism, ResolvedTrajectory& resolved) {
  if (mechanism.space != SpaceKind::planar)
    throw std::invalid_argument("the law 'steady-momentum' is only for planar mechanisms");
  Trajectory& trajectory = resolved.trajectory;
  const PathModel model =
      build_path_model(mechanism, trajectory, require_limited_quantities(mechanism, "shaking_moment"));
  resolved.outcome = model.outcome;
  if (model.outcome.status != MotionStatus::done) return;
  ConstantMomentumLaw constant_momentum = find_constant_momentum_law(model, trajectory.duration);
  if (!constant_momentum.refusal.empty()) {
    resolved.outcome = make_infeasible_outcome(constant_momentum.refusal);
    return;
  }
  trajectory.law = std::move(constant_momentum.law);
  resolved.optimised_law.emplace();
  resolved.optimised_law->duration = trajectory.duration;
  resolved.optimised_law->momentum = constant_momentum.momentum;
}

/// Finds the fastest or the gentlest law.
void apply_optimised_law(const Mechanism& mechanism, ResolvedTrajectory& resolved) {
  const Trajectory trajectory = resolved.trajectory;
  const MotionLawKind kind = trajectory.law.kind;
  const PathLimits law_limits = make_law_limits(mechanism, trajectory);
  const PathModel model = build_limited_path_model(mechanism, trajectory, law_limits);
  resolved.outcome = model.outcome;
  if (model.outcome.status != MotionStatus::done) return;
  const MinPeakLaw gentlest = find_motion_law(model, law_limits, trajectory);
  const TimeOptimalLaw& law = gentlest.law;
  if (!law.infeasibility_reason.empty()) {
    resolved.outcome = make_infeasible_outcome(law.infeasibility_reason);
    return;
  }
  resolved.trajectory.law = to_motion_law(kind, law);
  if (kind == MotionLawKind::time_optimal) resolved.trajectory.duration = law.duration();
  resolved.optimised_law = describe_law(model, law, resolved.trajectory.duration / law.duration());
  if (kind == MotionLawKind::min_peak) {
    resolved.optimised_law->objective = trajectory.min_peak_quantity;
    resolved.optimised_law->objective_value = gentlest.peak;
    resolved.optimised_law->unit = model.rows[law_limits.half_widths.size()].unit;
  }
  std::vector<double> bounds = law_limits.half_widths;
  bounds.resize(model.rows.size(), gentlest.peak);
  add_maximum_velocity_curve(model, bounds, resolved.phase_plane);
}

}  // namespace

ResolvedTrajectory resolve_trajectory(const Mechanism& mechanism, const Trajectory& trajectory) {
  ResolvedTrajectory resolved{{MotionStatus::done, 0, "", {}}, trajectory, std::nullopt, std::nullopt, {}};
  if (has_velocity_constraints(mechanism) && (trajectory.corridor || has_momentum_task(trajectory)))
    throw std::invalid_argument("constraints on speeds cannot be combined with a corridor or a kept momentum");
  if (has_prescribed_speeds(mechanism) && is_mechanism_dependent(trajectory.law.kind))
    throw std::invalid_argument(
        "a law that is optimised for the mechanism cannot be combined with a constraint on speeds with a value: rates "
        "are then not proportional to the progress along the path");
  resolved.outcome = optimise_corridor_path(mechanism, resolved.trajectory, resolved.corridor);
  if (resolved.outcome.status != MotionStatus::done) return resolved;
  resolved.outcome = solve_momentum_tasks(mechanism, resolved.trajectory);
  if (resolved.outcome.status != MotionStatus::done) return resolved;
  const MotionLawKind kind = trajectory.law.kind;
  if (is_mechanism_dependent(kind) && !resolved.trajectory.law.nodes.empty()) return resolved;
  if (kind == MotionLawKind::time_optimal || kind == MotionLawKind::min_peak) {
    apply_optimised_law(mechanism, resolved);
    return resolved;
  }
  if (kind == MotionLawKind::constant_momentum) apply_constant_momentum_law(mechanism, resolved);
  if (resolved.outcome.status == MotionStatus::done) add_mvc_of_limits(mechanism, resolved);
  return resolved;
}

}  // namespace balance::time_optimal
