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

namespace balance {

// The largest rates that limits leave along a path.

/// Fills the ceiling of a phase plane.
/// @param bounds one per row of the model
void add_maximum_velocity_curve(const PathModel& model, const std::vector<double>& bounds, PhasePlane& plane);

/// The law by which a path is run through with an angular momentum that does not change.
struct ConstantMomentumLaw {
  MotionLaw law;
  double momentum = 0;  ///< about the trajectory's point [N m s]
  double min_momentum_per_rate = 0,
         max_momentum_per_rate = 0;  ///< of the angular momentum per rate of the path's parameter [kg m^2]
  std::string refusal;               ///< why there is none; empty: there is
};

/// With h = g(s) s' constant the shaking moment vanishes: s' = h / g, s'' = −h² g' / g³, h = ∫ g ds / T. It exists where g keeps its
/// sign.
/// @param model of a planar mechanism whose first row is the shaking moment
/// @param duration T [s]
ConstantMomentumLaw find_constant_momentum_law(const PathModel& model, double duration);

namespace {

constexpr double curve_points = 400;        // of the whole path
constexpr double min_points_per_panel = 4;  // of a panel

}  // namespace

void add_maximum_velocity_curve(const PathModel& model, const std::vector<double>& bounds, PhasePlane& plane) {
  AccelerationLimits allowed(model, bounds);
  std::vector<double> place, rate;
  double guess = 0;
  for (std::size_t p = 0; p < model.value.panels().size(); ++p) {
    const Panel& panel = model.value.panels()[p];
    const double width = panel.end - panel.begin;
    const int pieces = static_cast<int>(std::max(min_points_per_panel, std::ceil(curve_points * width)));
    for (int k = 0; k <= pieces; ++k) {
      const double s = k == pieces ? panel.end : panel.begin + width * k / pieces;
      allowed.move_to(s, p, p + 1);
      allowed.drop_zero_inertia_rows();
      const VelocityBound here = allowed.max_velocity(guess);
      guess = std::isfinite(here.x) ? here.x : 0;
      if (!place.empty() && s == place.back() && std::sqrt(here.x) == rate.back()) continue;
      place.push_back(s);
      rate.push_back(std::sqrt(here.x));
    }
  }
  plane.mvc_path_parameter = Eigen::Map<const VectorX>(place.data(), static_cast<Eigen::Index>(place.size()));
  plane.mvc_path_rate = Eigen::Map<const VectorX>(rate.data(), static_cast<Eigen::Index>(rate.size()));
}

namespace {

constexpr int nodes_per_panel = 64;             // of a panel: between nodes the law is a quintic
constexpr double min_momentum_fraction = 1e-6;  // of the largest momentum per rate: nearer to zero the law has no bound

/// @param speed of what is driven, at the start, per rate of the path's parameter
std::string explain_sign_change(double place, const ConstantMomentumLaw& law, double speed) {
  const double unit = speed > 0 ? speed : 1;
  char text[320];
  std::snprintf(text, sizeof text,
                "at %.6g %% of the path the angular momentum cannot be kept: per unit of the drive's rate it goes "
                "through zero (it is "
                "from %.8g to %.8g in SI units)",
                100 * place, law.min_momentum_per_rate / unit, law.max_momentum_per_rate / unit);
  return text;
}

/// @return where the function is nearest to zero or beyond it, as seen from its mean
double find_momentum_range(const PiecewiseChebyshevSeries& g, ConstantMomentumLaw& law) {
  std::vector<double> places = find_roots(g.derivative(), 0);
  for (const Panel& panel : g.panels()) places.insert(places.end(), {panel.begin, panel.end});
  law.min_momentum_per_rate = INFINITY, law.max_momentum_per_rate = -INFINITY;
  double min_location = 0, max_location = 0, value = 0;
  for (const double place : places) {
    g.evaluate(g.find_panel(place, 0, g.panels().size()), place, &value);
    if (value < law.min_momentum_per_rate) law.min_momentum_per_rate = value, min_location = place;
    if (value > law.max_momentum_per_rate) law.max_momentum_per_rate = value, max_location = place;
  }
  return law.max_momentum_per_rate > -law.min_momentum_per_rate ? min_location : max_location;
}

}  // namespace

ConstantMomentumLaw find_constant_momentum_law(const PathModel& model, double duration) {
  ConstantMomentumLaw found;
  found.law.kind = MotionLawKind::constant_momentum;
  const PathConstraintRow& row = model.rows.front();
  const int column = row.a;
  if (column < 0) {
    found.refusal = "the mechanism has no angular momentum on this path that could be kept";
    return found;
  }
  std::vector<Panel> panels = model.value.panels();
  for (Panel& panel : panels) panel.coefficients = Samples(panel.coefficients.col(column));
  const PiecewiseChebyshevSeries g(std::move(panels)), sum = g.integral();
  VectorX all(model.value.function_count());
  const double narrow = find_momentum_range(g, found);
  if (!(found.min_momentum_per_rate * found.max_momentum_per_rate > 0) ||
      std::min(std::abs(found.min_momentum_per_rate), std::abs(found.max_momentum_per_rate)) <
          min_momentum_fraction * std::max(-found.min_momentum_per_rate, found.max_momentum_per_rate)) {
    found.refusal = explain_sign_change(narrow, found, model.start_speed);
    return found;
  }
  double whole = 0;
  sum.evaluate(sum.panels().size() - 1, 1, &whole);
  found.momentum = whole / duration;
  for (std::size_t p = 0; p < g.panels().size(); ++p)
    for (int k = p == 0 ? 0 : 1; k <= nodes_per_panel; ++k) {
      const Panel& panel = g.panels()[p];
      const double s = k == nodes_per_panel ? panel.end : panel.begin + (panel.end - panel.begin) * k / nodes_per_panel;
      double passed = 0;
      model.value.evaluate(p, s, all.data());
      sum.evaluate(p, s, &passed);
      const double here = all[column], rising = row.b < 0 ? 0 : all[row.b];  // g' is what s'² leaves of the moment
      const double rate = whole / here, second = -rate * rate * rising / here;
      found.law.nodes.push_back({passed / whole, s, rate, second, second});
    }
  found.law.nodes.back().tau = 1;
  return found;
}

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
