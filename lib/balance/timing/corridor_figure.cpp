#include "balance/timing/corridor_figure.hpp"

#include "balance/motion/law.hpp"
#include "balance/timing/law_slopes.hpp"
#include "balance/timing/path_source.hpp"

#include <algorithm>
#include <cmath>

namespace balance {
namespace {

constexpr int colours = 4;           // cubic B-splines that overlap
constexpr double difference = 3e-5;  // of the path's length
constexpr int moments = 1000;        // of a stated law at which its quantity is looked at

MotionOutcome no_law(const std::string& reason) { return {MotionStatus::limits_not_held, 0, reason, {}}; }

/// Of a stated law the quantity whose peak counts, nothing of limits.
StatedLimits task_of(const Mechanism& mechanism, const Trajectory& trajectory) {
  if (is_searched(trajectory.law.kind)) return law_task(mechanism, trajectory);
  refuse_changing_loads(mechanism, "the way within a corridor");
  validate(trajectory.law);
  return {find_or_throw(mechanism, trajectory.gentlest_of), {}, {}};
}

}  // namespace

CorridorFigure::CorridorFigure(const Mechanism& mechanism, const Trajectory& trajectory)
    : mechanism_(mechanism),
      trajectory_(trajectory),
      task_(task_of(mechanism, trajectory)),
      each_(trajectory.corridor->knots + 2) {
  Trajectory middle = trajectory_;
  middle.corridor.reset();
  const auto source = make_path_source(mechanism_, middle, task_.quantities);
  outcome_ = source->outcome();
  if (outcome_.status != MotionStatus::done) return;
  directions_ = source->corridor_components() - 1;
  step_ = difference * source->start_speed();
  if (trajectory_.law.kind != LawKind::fastest) unit_ = task_.quantities[task_.bounds.size()].unit;
  if (!is_searched(trajectory_.law.kind)) list_moments();
}

void CorridorFigure::list_moments() {
  const Law& law = trajectory_.law;
  const double duration = trajectory_.duration;
  const auto add = [&](double tau, Side side) {
    const LawValue here = evaluate(law, tau, side);
    moments_.push_back({here.s, here.ds / duration, here.dds / (duration * duration), 0});
  };
  for (int k = 0; k <= moments; ++k) add(static_cast<double>(k) / moments, k == 0 ? Side::after : Side::before);
  for (const double tau : jumps(law)) add(tau, Side::before), add(tau, Side::after);
}

Trajectory CorridorFigure::with(const VectorX& controls) const {
  Trajectory trajectory = trajectory_;
  trajectory.corridor->controls.assign(controls.begin(), controls.end());
  return trajectory;
}

PathModel CorridorFigure::model_of(const VectorX& controls) const {
  return model_limits(mechanism_, with(controls), task_);
}

VectorX CorridorFigure::pieces(const VectorX& controls) {
  controls_ = controls;
  neighbours_.clear();
  model_ = model_of(controls);
  refusal_ = model_.outcome;
  if (model_.outcome.status != MotionStatus::done) return {};
  if (!is_searched(trajectory_.law.kind)) return fixed_pieces();
  law_ = find_law(model_, task_, trajectory_);
  if (!law_.law.refusal.empty()) {
    refusal_ = no_law(law_.law.refusal);
    return {};
  }
  return VectorX::Constant(1, trajectory_.law.kind == LawKind::fastest ? law_.law.duration() : law_.peak);
}

MatrixX CorridorFigure::slopes() {
  look_round();
  if (!is_searched(trajectory_.law.kind)) return fixed_slopes();
  return found_slopes().transpose();
}

void CorridorFigure::look_round() {
  neighbours_.clear();
  for (Eigen::Index m = 0; m < directions_; ++m)
    for (int colour = 0; colour < colours; ++colour) {
      VectorX way = VectorX::Zero(controls_.size());
      for (Eigen::Index k = 0; k < each_; ++k)
        if ((k + 1) % colours == colour) way[m * each_ + k] = step_;
      Neighbours next{model_of(controls_ + way), model_of(controls_ - way), 2 * step_};
      for (PathModel* model : {&next.above, &next.below})
        if (model->outcome.status != MotionStatus::done) *model = model_, next.step -= step_;
      neighbours_.push_back(std::move(next));
    }
}

VectorX CorridorFigure::row_slopes(const PathMoment& moment, const RowValue& here) const {
  VectorX slopes = VectorX::Zero(controls_.size());
  if (!(here.magnitude > 0)) return slopes;
  const Eigen::Index last = each_ - 1;  // between the knots first and first + 1 four splines overlap
  const auto first =
      std::clamp<Eigen::Index>(static_cast<Eigen::Index>(moment.s * static_cast<double>(last)), 0, last - 1);
  for (Eigen::Index m = 0; m < directions_; ++m)
    for (Eigen::Index spline = first; spline < first + colours; ++spline) {
      if (spline == 0 || spline > each_) continue;  // the ends stay
      const Neighbours& next = neighbours_[static_cast<std::size_t>(m * colours + spline % colours)];
      if (next.step == 0) continue;
      const VectorX change = value_of_row(next.above, moment).value - value_of_row(next.below, moment).value;
      slopes[m * each_ + spline - 1] = here.value.dot(change) / (here.magnitude * next.step);
    }
  return slopes;
}

VectorX CorridorFigure::fixed_pieces() const {
  VectorX pieces(static_cast<Eigen::Index>(moments_.size() * model_.rows.size()));
  Eigen::Index i = 0;
  for (PathMoment moment : moments_)
    for (std::size_t row = 0; row < model_.rows.size(); ++row) {
      moment.row = static_cast<int>(row);
      pieces[i++] = value_of_row(model_, moment).magnitude;
    }
  return pieces;
}

MatrixX CorridorFigure::fixed_slopes() const {
  MatrixX slopes(static_cast<Eigen::Index>(moments_.size() * model_.rows.size()), controls_.size());
  Eigen::Index i = 0;
  for (PathMoment moment : moments_)
    for (std::size_t row = 0; row < model_.rows.size(); ++row) {
      moment.row = static_cast<int>(row);
      slopes.row(i++) = row_slopes(moment, value_of_row(model_, moment)).transpose();
    }
  return slopes;
}

/// The least peak f in a duration is where the least duration T(f, x) is that: df/dx = −(∂T/∂x) / (∂T/∂f).
VectorX CorridorFigure::found_slopes() const {
  const Eigen::Index n = controls_.size();
  const std::size_t limits = task_.bounds.size();
  const RowSlopes slopes = [&](const PathMoment& moment, const RowValue& here) {
    VectorX all(n + 1);
    all << row_slopes(moment, here), static_cast<std::size_t>(moment.row) < limits ? 0.0 : -1.0;
    return all;
  };
  const VectorX all = duration_slopes(model_, law_.bounds, law_.law, slopes, n + 1);
  if (trajectory_.law.kind == LawKind::fastest) return all.head(n);
  if (!(all[n] < 0)) return VectorX::Zero(n);  // rest alone decides
  return all.head(n) * (-law_.peak / law_.bounds[limits] / all[n]);
}

}  // namespace balance
