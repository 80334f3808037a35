#include "balance/timing/corridor_figure.hpp"

#include "balance/motion/law.hpp"
#include "balance/timing/law_slopes.hpp"
#include "balance/timing/path_source.hpp"

#include <algorithm>
#include <cmath>

namespace balance {
namespace {

constexpr int overlapping_bsplines = 4;            // cubic B-splines that overlap
constexpr double difference_step_fraction = 3e-5;  // of the path's length
constexpr int law_sample_intervals = 1000;         // of a stated law at which its quantity is looked at

MotionOutcome make_limits_infeasible_outcome(const std::string& reason) {
  return {MotionStatus::limits_not_held, 0, reason, {}};
}

/// Of a stated law the quantity whose peak counts, nothing of limits.
PathLimits make_corridor_limits(const Mechanism& mechanism, const Trajectory& trajectory) {
  if (is_mechanism_dependent(trajectory.law.kind)) return make_law_limits(mechanism, trajectory);
  require_constant_loads(mechanism, "the way within a corridor");
  validate(trajectory.law);
  return {require_limited_quantities(mechanism, trajectory.min_peak_quantity), {}, {}};
}

}  // namespace

CorridorObjective::CorridorObjective(const Mechanism& mechanism, const Trajectory& trajectory)
    : mechanism_(mechanism),
      trajectory_(trajectory),
      limits_(make_corridor_limits(mechanism, trajectory)),
      control_points_per_direction_(trajectory.corridor->inner_knots + 2) {
  Trajectory middle = trajectory_;
  middle.corridor.reset();
  const auto source = make_path_dynamics_sampler(mechanism_, middle, limits_.quantities);
  outcome_ = source->outcome();
  if (outcome_.status != MotionStatus::done) return;
  directions_ = source->corridor_components() - 1;
  step_ = difference_step_fraction * source->start_speed();
  if (trajectory_.law.kind != MotionLawKind::time_optimal) unit_ = limits_.quantities[limits_.half_widths.size()].unit;
  if (!is_mechanism_dependent(trajectory_.law.kind)) list_path_points();
}

void CorridorObjective::list_path_points() {
  const MotionLaw& law = trajectory_.law;
  const double duration = trajectory_.duration;
  const auto add = [&](double tau, Side side) {
    const MotionLawValue here = evaluate(law, tau, side);
    moments_.push_back({here.s, here.ds / duration, here.dds / (duration * duration), 0});
  };
  for (int k = 0; k <= law_sample_intervals; ++k)
    add(static_cast<double>(k) / law_sample_intervals, k == 0 ? Side::after : Side::before);
  for (const double tau : find_acceleration_jumps(law)) add(tau, Side::before), add(tau, Side::after);
}

Trajectory CorridorObjective::with_control_points(const VectorX& controls) const {
  Trajectory trajectory = trajectory_;
  trajectory.corridor->control_points.assign(controls.begin(), controls.end());
  return trajectory;
}

PathModel CorridorObjective::model_of(const VectorX& controls) const {
  return build_limited_path_model(mechanism_, with_control_points(controls), limits_);
}

VectorX CorridorObjective::terms(const VectorX& controls) {
  controls_ = controls;
  neighbours_.clear();
  model_ = model_of(controls);
  refusal_ = model_.outcome;
  if (model_.outcome.status != MotionStatus::done) return {};
  if (!is_mechanism_dependent(trajectory_.law.kind)) return stated_law_terms();
  law_ = find_motion_law(model_, limits_, trajectory_);
  if (!law_.law.infeasibility_reason.empty()) {
    refusal_ = make_limits_infeasible_outcome(law_.law.infeasibility_reason);
    return {};
  }
  return VectorX::Constant(1, trajectory_.law.kind == MotionLawKind::time_optimal ? law_.law.duration() : law_.peak);
}

MatrixX CorridorObjective::jacobian() {
  build_neighbours();
  if (!is_mechanism_dependent(trajectory_.law.kind)) return stated_law_jacobian();
  return optimal_law_gradient().transpose();
}

void CorridorObjective::build_neighbours() {
  neighbours_.clear();
  for (Eigen::Index m = 0; m < directions_; ++m)
    for (int colour = 0; colour < overlapping_bsplines; ++colour) {
      VectorX way = VectorX::Zero(controls_.size());
      for (Eigen::Index k = 0; k < control_points_per_direction_; ++k)
        if ((k + 1) % overlapping_bsplines == colour) way[m * control_points_per_direction_ + k] = step_;
      Neighbours next{model_of(controls_ + way), model_of(controls_ - way), 2 * step_};
      for (PathModel* model : {&next.above, &next.below})
        if (model->outcome.status != MotionStatus::done) *model = model_, next.step -= step_;
      neighbours_.push_back(std::move(next));
    }
}

VectorX CorridorObjective::constraint_gradient(const PathPoint& moment, const ConstraintValue& here) const {
  VectorX slopes = VectorX::Zero(controls_.size());
  if (!(here.magnitude > 0)) return slopes;
  const Eigen::Index last =
      control_points_per_direction_ - 1;  // between the knots first and first + 1 four splines overlap
  const auto first =
      std::clamp<Eigen::Index>(static_cast<Eigen::Index>(moment.s * static_cast<double>(last)), 0, last - 1);
  for (Eigen::Index m = 0; m < directions_; ++m)
    for (Eigen::Index spline = first; spline < first + overlapping_bsplines; ++spline) {
      if (spline == 0 || spline > control_points_per_direction_) continue;  // the ends stay
      const Neighbours& next =
          neighbours_[static_cast<std::size_t>(m * overlapping_bsplines + spline % overlapping_bsplines)];
      if (next.step == 0) continue;
      const VectorX change =
          evaluate_constraint(next.above, moment).value - evaluate_constraint(next.below, moment).value;
      slopes[m * control_points_per_direction_ + spline - 1] = here.value.dot(change) / (here.magnitude * next.step);
    }
  return slopes;
}

VectorX CorridorObjective::stated_law_terms() const {
  VectorX pieces(static_cast<Eigen::Index>(moments_.size() * model_.rows.size()));
  Eigen::Index i = 0;
  for (PathPoint moment : moments_)
    for (std::size_t row = 0; row < model_.rows.size(); ++row) {
      moment.row = static_cast<int>(row);
      pieces[i++] = evaluate_constraint(model_, moment).magnitude;
    }
  return pieces;
}

MatrixX CorridorObjective::stated_law_jacobian() const {
  MatrixX slopes(static_cast<Eigen::Index>(moments_.size() * model_.rows.size()), controls_.size());
  Eigen::Index i = 0;
  for (PathPoint moment : moments_)
    for (std::size_t row = 0; row < model_.rows.size(); ++row) {
      moment.row = static_cast<int>(row);
      slopes.row(i++) = constraint_gradient(moment, evaluate_constraint(model_, moment)).transpose();
    }
  return slopes;
}

/// The least peak f in a duration is where the least duration T(f, x) is that: df/dx = −(∂T/∂x) / (∂T/∂f).
VectorX CorridorObjective::optimal_law_gradient() const {
  const Eigen::Index n = controls_.size();
  const std::size_t limits = limits_.half_widths.size();
  const ConstraintGradient slopes = [&](const PathPoint& moment, const ConstraintValue& here) {
    VectorX all(n + 1);
    all << constraint_gradient(moment, here), static_cast<std::size_t>(moment.row) < limits ? 0.0 : -1.0;
    return all;
  };
  const VectorX all = differentiate_duration(model_, law_.bounds, law_.law, slopes, n + 1);
  if (trajectory_.law.kind == MotionLawKind::time_optimal) return all.head(n);
  if (!(all[n] < 0)) return VectorX::Zero(n);  // rest alone decides
  return all.head(n) * (-law_.peak / law_.bounds[limits] / all[n]);
}

}  // namespace balance
