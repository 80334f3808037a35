#include "balance/mechanics/kinematics/motion_stepper.hpp"

#include "balance/foundation/base/cpu_time.hpp"
#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/foundation/numerics/ode_extrapolation.hpp"
#include "balance/mechanics/kinematics/assembly.hpp"
#include "balance/mechanics/kinematics/assembly_diagnostics.hpp"
#include "balance/mechanics/kinematics/joint_coordinates.hpp"
#include "balance/mechanics/trajectory/motion_outcome.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

namespace balance {

namespace {

constexpr double min_step_fraction = 0x1p-24;  // of a step, before it is given up

/// Columns whose coordinate changes entries of the equations' matrix.
template <class S>
std::vector<ColumnId> find_matrix_columns(const Tree<S>& tree, const Drive<S>& drive) {
  std::set<ColumnId> columns;
  const auto add = [&](NodeId node) {
    if (tree.nodes[node].motion != NodeMotion::weld) columns.insert(tree.nodes[node].column);
  };
  for (const Closure<S>& closure : tree.closures)
    for (const PathStep& step : closure.path) add(step.node);
  if (!drive.point.empty() || !drive.rotation.empty())
    for (const NodeId node : drive.tool_path) add(node);
  for (std::size_t node = 1; !drive.com.empty() && node < tree.nodes.size(); ++node) add(static_cast<int>(node));
  return {columns.begin(), columns.end()};
}

}  // namespace

template <class S>
MotionStepper<S>::MotionStepper(const Mechanism& mechanism, Tree<S>& tree, const CompiledTrajectory<S>& plan)
    : mechanism_(mechanism),
      tree_(tree),
      plan_(plan),
      equations_(tree, plan.drive, plan.has_redundant_closures),
      round_off_(newton_residual_tolerance * ground_extent(mechanism)),
      state_(tree.nodes.size()),
      matrix_columns_(find_matrix_columns(tree, plan.drive)),
      singularity_monitor_(mechanism, tree, plan, {&second_previous_, &previous_, &now_}) {
  const int n = tree.columns;
  for (CoordinateSample* moment : {&now_, &previous_, &second_previous_, &next_})
    moment->y.setZero(n), moment->dy.setZero(n), moment->ddy.setZero(n);
  predicted_.setZero(n);
  trial_.setZero(n);
  x_.assign(std::max(n, equations_.rows()), 0);
  rates_ = x_;
  has_velocity_closures_ = tree.position_rows < tree.closure_rows;
  direct_ = tree.closures.empty() && plan.drive.row_count() == static_cast<int>(plan.drive.linear.size());
  for (const LinearQuantity& quantity : plan.drive.linear)
    direct_ = direct_ && quantity.terms.size() == 1 && quantity.terms[0].second != 0;
}

template <class S>
bool MotionStepper<S>::begin() {
  now_.y = plan_.start;
  now_.time = 0;
  history_count_ = 0;
  plan_.prescribed_motion->at(0, Side::after, sample_);
  if (direct_ && !equations_.structurally_singular()) {
    set_explicit(0);
    return true;
  }
  reset_spherical_references(0.5);
  trial_ = now_.y;
  if (equations_.structurally_singular() || !newton(trial_)) {
    explain_stop(StepResult::no_convergence, 0);
    return false;
  }
  now_.y = trial_;
  differentiate(now_);
  if (store_matrices()) {
    singularity_monitor_.begin(equations_, equations_.regularity(), hold_pivot_);
    return true;
  }
  explain_stop(StepResult::actuation_singular, 0);
  return false;
}

/// The watched matrices are to be compared with those of this moment.
template <class S>
bool MotionStepper<S>::store_matrices() {
  equations_.store();
  if (guard_ == nullptr) return true;
  hold_pivot_ = guard_->factorise(equations_);
  guard_->store();
  return hold_pivot_ >= pivot_threshold_;
}

template <class S>
void MotionStepper<S>::set_explicit(double time) {
  now_.time = time;
  for (std::size_t k = 0; k < plan_.drive.linear.size(); ++k) {
    const LinearQuantity& quantity = plan_.drive.linear[k];
    const auto& [column, coefficient] = quantity.terms[0];
    const double inverse = 1 / coefficient;
    now_.y[column] = (sample_.value[k] - quantity.constant) * inverse;
    now_.dy[column] = sample_.rate[k] * inverse;
    now_.ddy[column] = sample_.acceleration[k] * inverse;
  }
}

template <class S>
bool MotionStepper<S>::newton(VectorX& y) {
  double last = INFINITY;
  for (iterations_ = 0; iterations_ <= max_newton_iterations; ++iterations_) {
    compute_poses(tree_, y.data(), state_);
    equations_.evaluate(state_, y.data(), sample_, x_.data());
    double worst = 0;
    for (int r = 0; r < equations_.rows(); ++r) worst = std::max(worst, std::abs(x_[r]));
    if (!std::isfinite(worst) || !equations_.factorise(pivot_threshold_)) return false;
    equations_.velocity_rhs(sample_, rates_.data());
    equations_.solve_pair(x_.data(), rates_.data());
    for (int c = 0; c < tree_.columns; ++c) y[c] -= x_[c];
    // Either small, or as small as round-off allows. The last correction is too small to show in the poses, but must be
    // made: the predictor would magnify what it leaves undone.
    if (worst <= round_off_ || (worst <= 10 * round_off_ && worst >= last)) return true;
    last = worst;
  }
  return false;
}

/// Continues the polynomial through the last configurations and their two derivatives by one step: degree 2 from one, 5 from
/// two, 8 from three equidistant ones. The weights are those of Hermite interpolation.
template <class S>
void MotionStepper<S>::predict(double time) {
  const double h = time - now_.time;
  const auto equidistant = [h](const CoordinateSample& a, const CoordinateSample& b) {
    return std::abs(b.time - a.time - h) <= 1e-6 * h;
  };
  const int known = history_count_ < 1 || !equidistant(previous_, now_)               ? 1
                    : history_count_ < 2 || !equidistant(second_previous_, previous_) ? 2
                                                                                      : 3;
  const double hh = h * h;
  for (int c = 0; c < tree_.columns; ++c) {
    const double y = now_.y[c], v = h * now_.dy[c], a = hh * now_.ddy[c];
    if (known == 1) {
      predicted_[c] = y + v + a / 2;
      continue;
    }
    const double y1 = previous_.y[c], v1 = h * previous_.dy[c], a1 = hh * previous_.ddy[c];
    if (known == 2) {
      predicted_[c] = 32 * y - 31 * y1 - 16 * v - 14 * v1 + 4 * a - 2 * a1;
      continue;
    }
    const double y2 = second_previous_.y[c], v2 = h * second_previous_.dy[c], a2 = hh * second_previous_.ddy[c];
    predicted_[c] = 229.5 * y - 351 * y1 + 122.5 * y2 - 94.5 * v - 54 * v1 + 43.5 * v2 + 13.5 * a - 54 * a1 + 4.5 * a2;
  }
}

template <class S>
typename MotionStepper<S>::StepResult MotionStepper<S>::step(double time) {
  plan_.prescribed_motion->at(time, Side::after, sample_);
  if (direct_) {
    set_explicit(time);
    return StepResult::done;
  }
  if (--evaluations_left_ < 0) return StepResult::evaluations_exhausted;
  Deadline::check();
  if (!has_velocity_closures_)
    predict(time);
  else if (!integrate(time))
    return evaluations_left_ < 0 ? StepResult::evaluations_exhausted : StepResult::no_convergence;
  trial_ = predicted_;
  if (!newton(trial_)) return StepResult::no_convergence;
  const std::vector<double>& scale = equations_.column_scale();
  for (int c = 0; c < tree_.columns; ++c)
    if (std::abs(trial_[c] - predicted_[c]) > max_correction * scale[c]) return StepResult::far_from_prediction;
  next_.time = time;
  next_.y = trial_;
  differentiate(next_);
  const StepResult attempt = check_step(next_);
  return attempt == StepResult::done ? accept() : attempt;
}

/// How far the mechanism turns on the way to the next moment [rad, characteristic lengths]: the most of any coordinate that matters, by the
/// rates at both ends too, for it may turn back in between.
template <class S>
double MotionStepper<S>::step_distance(const CoordinateSample& next) const {
  const double h = next.time - now_.time;
  const std::vector<double>& scale = equations_.column_scale();
  double most = 0;
  for (const ColumnId c : matrix_columns_) {
    const double rate = std::max(std::abs(now_.dy[c]), std::abs(next.dy[c]));
    most = std::max(most, std::max(std::abs(next.y[c] - now_.y[c]), h * rate) / scale[c]);
  }
  return most;
}

/// Could a watched matrix have been singular since the present moment? The equations are those of the next one.
template <class S>
typename MotionStepper<S>::StepResult MotionStepper<S>::check_step(const CoordinateSample& next) {
  way_ = step_distance(next);
  const double curvature = way_ * way_;  // h²/8 of second derivatives, three turns in a chain
  if (!(curvature <= max_matrix_curvature * equations_.regularity()) || !equations_.is_near_stored(max_matrix_change))
    return StepResult::singular;
  if (guard_ != nullptr) {
    hold_pivot_ = guard_->factorise(equations_);
    if (!(hold_pivot_ >= pivot_threshold_ && curvature <= max_matrix_curvature * hold_pivot_ &&
          guard_->is_near_stored(max_matrix_change)))
      return StepResult::actuation_singular;
    actuation_extrapolation_.add_sample(hold_pivot_, next.time);
  }
  approach_.add_sample(equations_.regularity(), next.time);
  return StepResult::done;
}

template <class S>
typename MotionStepper<S>::StepResult MotionStepper<S>::accept() {
  std::swap(second_previous_, previous_);
  std::swap(previous_, now_);
  std::swap(now_, next_);
  history_count_ = std::min(history_count_ + 1, 2);
  singularity_monitor_.sample(equations_, equations_.regularity(), hold_pivot_, way_);
  if (reset_spherical_references(1)) {  // same configuration, other coordinates
    if (!newton(now_.y)) return StepResult::no_convergence;
    differentiate(now_);
    history_count_ = 0;
    if (!store_matrices()) return StepResult::actuation_singular;
    singularity_monitor_.restart(equations_, equations_.regularity(), hold_pivot_);
    return StepResult::done;
  }
  equations_.store();
  if (guard_ != nullptr) guard_->store();
  return StepResult::done;
}

/// Rereferences every spherical joint whose middle angle is beyond the limit [rad]: at a right angle its coordinates fail.
template <class S>
bool MotionStepper<S>::reset_spherical_references(double limit) {
  bool any = false;
  for (const NodeId spherical : tree_.spherical_joints) {
    const double middle = std::remainder(now_.y[tree_.nodes[spherical + 1].column], 2 * std::numbers::pi);
    if (std::abs(middle) < limit) continue;
    reset_spherical_reference(tree_, spherical, now_.y.data());
    ++references_;
    any = true;
  }
  return any;
}

template <class S>
void MotionStepper<S>::differentiate(CoordinateSample& moment) {
  std::copy_n(rates_.data(), tree_.columns, moment.dy.data());
  compute_angular_velocities(tree_, moment.dy.data(), state_);
  if (tree_.has_sliding_closures) compute_origin_velocities(tree_, moment.dy.data(), state_);
  compute_accelerations<S>(tree_, moment.dy.data(), nullptr, S::Vector::Zero(), state_);
  equations_.acceleration_rhs(state_, sample_, x_.data());
  equations_.solve(x_.data());
  std::copy_n(x_.data(), tree_.columns, moment.ddy.data());
}

template <class S>
void MotionStepper<S>::update_accelerations(Side side) {
  plan_.prescribed_motion->at(now_.time, side, sample_);
  if (direct_) return set_explicit(now_.time);
  compute_accelerations<S>(tree_, now_.dy.data(), nullptr, S::Vector::Zero(), state_);
  equations_.acceleration_rhs(state_, sample_, x_.data());
  equations_.solve(x_.data());
  std::copy_n(x_.data(), tree_.columns, now_.ddy.data());
  if (side == Side::after) history_count_ = 0;  // nothing smooth to continue
}

template <class S>
bool MotionStepper<S>::advance(double time) {
  Deadline::check();
  if (direct_) return step(time) == StepResult::done;
  evaluations_left_ += evaluations_per_stop;
  const double smallest = min_step_fraction * std::min(time - now_.time, plan_.prescribed_motion->duration() / 1024);
  double size = std::min(time - now_.time, next_step_size_);
  int total = 0;
  while (now_.time < time) {
    // the last piece ends exactly where it should
    double next = time - now_.time < 1.5 * size ? time : now_.time + size;
    const double longest = plan_.prescribed_motion->max_step(now_.time);
    if (next - now_.time > (1 + 1e-6) * longest) next = now_.time + longest;
    const StepResult attempt = step(next);
    total += iterations_;
    if (attempt == StepResult::done) {
      next_step_size_ = size *= 2;
      if (now_.time < budget_reset_time_) continue;
      budget_reset_time_ = now_.time + plan_.prescribed_motion->duration() / 1000;
      evaluations_left_ = std::max(evaluations_left_, max_evaluations);
    } else if (attempt == StepResult::evaluations_exhausted ||
               (size = std::min(size, next - now_.time) / 2) < smallest) {
      explain_stop(attempt, smallest);
      return false;
    }
  }
  iterations_ = total;
  return true;
}

template class MotionStepper<Planar>;
template class MotionStepper<Spatial>;

// Steps to moments that were found elsewhere.
template <class S>
void MotionStepper<S>::adopt_step(const CoordinateSample& next, const StepReport& measures) {
  std::swap(second_previous_, previous_);
  std::swap(previous_, now_);
  now_ = next;
  history_count_ = std::min(history_count_ + 1, 2);
  iterations_ = measures.iterations;
  if (direct_) return;
  way_ = measures.distance;
  hold_pivot_ = measures.actuation_pivot;
  if (guard_ != nullptr) actuation_extrapolation_.add_sample(hold_pivot_, next.time);
  approach_.add_sample(measures.pivot, next.time);
  singularity_monitor_.sample(equations_, measures.pivot, hold_pivot_, way_);
}

template <class S>
void MotionStepper<S>::synchronise(bool keep) {
  plan_.prescribed_motion->at(now_.time, Side::after, sample_);
  if (direct_) return;
  compute_poses(tree_, now_.y.data(), state_);
  equations_.evaluate(state_, now_.y.data(), sample_, x_.data());
  compute_angular_velocities(tree_, now_.dy.data(), state_);
  if (tree_.has_sliding_closures) compute_origin_velocities(tree_, now_.dy.data(), state_);
  if (!keep) return;
  equations_.factorise(pivot_threshold_);
  store_matrices();
}

#define BALANCE_INSTANTIATE(S)                                                                 \
  template void MotionStepper<S>::adopt_step(const CoordinateSample& next, const StepReport&); \
  template void MotionStepper<S>::synchronise(bool);
BALANCE_INSTANTIATE(Planar)
BALANCE_INSTANTIATE(Spatial)
#undef BALANCE_INSTANTIATE

// The way of a mechanism in which something rolls: rates are prescribed, and places follow from all of the way.

namespace {

constexpr double integration_tolerance = 1e-13;  // of a step, in radians or characteristic lengths

}  // namespace

/// Rates that the closures and the drive determine, at any configuration.
template <class S>
bool MotionStepper<S>::rates_at(double time, const VectorX& y, VectorX& dy) {
  if (--evaluations_left_ < 0) return false;
  DriveSample sample;
  plan_.prescribed_motion->at(time, Side::after, sample);
  compute_poses(tree_, y.data(), state_);
  equations_.evaluate(state_, y.data(), sample, x_.data());
  if (!y.allFinite() || !equations_.factorise(pivot_threshold_)) return false;
  equations_.velocity_rhs(sample, rates_.data());
  equations_.solve(rates_.data());
  std::copy_n(rates_.data(), tree_.columns, dy.data());
  return true;
}

/// What Newton's corrections cannot find: they keep to what rates are possible.
template <class S>
bool MotionStepper<S>::integrate(double time) {
  const VectorX scale = Eigen::Map<const VectorX>(equations_.column_scale().data(), tree_.columns);
  predicted_ = now_.y;
  const auto rates = [this](double at, const VectorX& y, VectorX& dy) { return rates_at(at, y, dy); };
  return step_by_extrapolation(rates, now_.time, time - now_.time, now_.dy, scale, integration_tolerance, predicted_);
}

#define BALANCE_INSTANTIATE(S)                                                \
  template bool MotionStepper<S>::rates_at(double, const VectorX&, VectorX&); \
  template bool MotionStepper<S>::integrate(double);
BALANCE_INSTANTIATE(Planar)
BALANCE_INSTANTIATE(Spatial)
#undef BALANCE_INSTANTIATE

// Where a motion cannot go on: the place, and which matrix has become singular there.
template <class S>
double MotionStepper<S>::mobility() {
  if (direct_) return 1;
  return equations_.min_singular_value();
}

/// On from the last good moment, nearer to the singular configuration than results are wanted: to where steps fail for good, or to
/// the smallest pivot if it is only touched. Leaves the present moment there.
template <class S>
void MotionStepper<S>::locate_singularity(StepResult attempt, double smallest) {
  const bool hold = attempt == StepResult::actuation_singular;
  const double duration = plan_.prescribed_motion->duration();
  // Round-off moves a configuration by 1e-16 / pivot of what determines it, so that the pivot itself is no better known than this.
  pivot_threshold_ = hold ? 1e-11 : 2e-8;
  evaluations_left_ = max_evaluations / 10;
  const auto pivot = [&] { return hold ? guard_->factorise(equations_) : equations_.regularity(); };
  double size = smallest, least = INFINITY;
  CoordinateSample nearest = now_;
  while (now_.time < duration) {
    const double next = duration - now_.time < 1.5 * size ? duration : now_.time + size;
    if (step(next) == StepResult::done) {
      const double reached = pivot();
      if (reached > 2 * least) break;
      if (reached < least) least = reached, nearest = now_;
      size *= 2;
    } else if (evaluations_left_ < 0 || (size = std::min(size, next - now_.time) / 2) < smallest) {
      break;
    }
  }
  now_ = nearest;
}

/// What to tell the user, by which matrix has lost rank at the last good configuration.
/// @param smallest step that was tried [s]; 0 if there was none
template <class S>
void MotionStepper<S>::explain_stop(StepResult attempt, double smallest) {
  if (smallest > 0) locate_singularity(attempt, smallest);
  const PivotExtrapolation& approach = attempt == StepResult::actuation_singular ? actuation_extrapolation_ : approach_;
  const double time = std::min(approach.extrapolate_zero(now_.time), plan_.prescribed_motion->duration());
  compute_poses(tree_, now_.y.data(), state_);
  std::string links = describe_collinear_links(mechanism_, tree_, state_);
  if (has_velocity_closures_ && links.empty())
    links = describe_flat_disc(mechanism_, compute_coordinates(mechanism_, tree_, now_.y));
  const std::string where =
      format_configuration(mechanism_, tree_, now_.y.data()) + (links.empty() ? "" : ", where " + links);
  const auto [status, what] = diagnose(attempt);
  if (status == MotionStatus::actuation_singularity) {
    outcome_ = make_actuation_singularity_outcome(time, where);
    return;
  }
  outcome_.time = time;
  outcome_.status = status;
  outcome_.reason = format_time_prefix(time) + what + "; configuration: " + where;
}

template <class S>
std::pair<MotionStatus, const char*> MotionStepper<S>::diagnose(StepResult attempt) {
  ConstraintSystem<S> system(tree_, plan_.drive);
  MatrixX jacobian;
  plan_.prescribed_motion->at(std::min(now_.time, plan_.prescribed_motion->duration()), Side::after, sample_);
  system.velocity_jacobian(now_.y, sample_, jacobian);
  const int rank = tree_.columns - plan_.freedoms;
  const auto relative = [](const MatrixX& matrix, int k) {
    if (k == 0 || matrix.size() == 0) return 1.0;
    const VectorX values = singular_values(matrix);
    return values[0] > 0 ? values[k - 1] / values[0] : 0.0;
  };
  const double loops = relative(jacobian.topRows(tree_.closure_rows), rank);
  const double all = relative(jacobian, std::min<int>(tree_.columns, static_cast<int>(jacobian.rows())));
  // At distance ε from a singularity the values are of the order √ε; closures without rank do not hold either.
  const double lost = attempt == StepResult::actuation_singular ? 1e-5 : 0.02;
  if (loops < lost && loops < 10 * all)
    return {MotionStatus::constraint_singularity,
            "constraint singularity: the loop closures lose rank, the mechanism gains a freedom"};
  if (attempt == StepResult::actuation_singular) return {MotionStatus::actuation_singularity, ""};
  if (all < lost)
    return {MotionStatus::drive_singularity,
            "drive singularity: the prescribed quantities no longer determine the motion (the path may leave the "
            "workspace here)"};
  if (attempt == StepResult::no_convergence)
    return {MotionStatus::unreachable, "the prescribed values cannot be reached"};
  if (attempt == StepResult::evaluations_exhausted)
    return {MotionStatus::unreachable,
            "the way cannot be followed further: rates change so fast that steps become shorter without end"};
  return {MotionStatus::assembly_jump, "the motion could only go on by a jump to another assembly mode"};
}

#define BALANCE_INSTANTIATE(S)                                                              \
  template double MotionStepper<S>::mobility();                                             \
  template void MotionStepper<S>::locate_singularity(MotionStepper<S>::StepResult, double); \
  template void MotionStepper<S>::explain_stop(MotionStepper<S>::StepResult, double);       \
  template std::pair<MotionStatus, const char*> MotionStepper<S>::diagnose(MotionStepper<S>::StepResult);
BALANCE_INSTANTIATE(Planar)
BALANCE_INSTANTIATE(Spatial)
#undef BALANCE_INSTANTIATE

}  // namespace balance
