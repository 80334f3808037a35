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

namespace balance::kinematics {

namespace {

constexpr double min_step_fraction = 0x1p-24;  // of a step, below which it is given up

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
      residual_tolerance_(newton_residual_tolerance * ground_extent(mechanism)),
      state_(tree.nodes.size()),
      matrix_columns_(find_matrix_columns(tree, plan.drive)),
      singularity_monitor_(mechanism, tree, plan, {&second_previous_, &previous_, &current_}) {
  const int n = tree.columns;
  for (CoordinateSample* sample : {&current_, &previous_, &second_previous_, &next_})
    sample->y.setZero(n), sample->dy.setZero(n), sample->ddy.setZero(n);
  predicted_.setZero(n);
  trial_.setZero(n);
  x_.assign(std::max(n, equations_.rows()), 0);
  rates_ = x_;
  has_velocity_closures_ = tree.position_rows < tree.closure_rows;
  is_explicit_ = tree.closures.empty() && plan.drive.row_count() == static_cast<int>(plan.drive.linear.size());
  for (const LinearQuantity& quantity : plan.drive.linear)
    is_explicit_ = is_explicit_ && quantity.terms.size() == 1 && quantity.terms[0].second != 0;
}

template <class S>
bool MotionStepper<S>::begin() {
  current_.y = plan_.start;
  current_.time = 0;
  history_count_ = 0;
  plan_.prescribed_motion->at(0, trajectory::Side::after, sample_);
  if (is_explicit_ && !equations_.structurally_singular()) {
    set_explicit(0);
    return true;
  }
  reset_spherical_references(0.5);
  trial_ = current_.y;
  if (equations_.structurally_singular() || !newton(trial_)) {
    explain_stop(StepResult::no_convergence, 0);
    return false;
  }
  current_.y = trial_;
  differentiate(current_);
  if (store_matrices()) {
    singularity_monitor_.begin(equations_, equations_.regularity(), actuation_pivot_);
    return true;
  }
  explain_stop(StepResult::actuation_singular, 0);
  return false;
}

/// Stores the monitored matrices of this instant for later comparison. @return false at an actuation singularity
template <class S>
bool MotionStepper<S>::store_matrices() {
  equations_.store();
  if (regularity_monitor_ == nullptr) return true;
  actuation_pivot_ = regularity_monitor_->factorise(equations_);
  regularity_monitor_->store();
  return actuation_pivot_ >= pivot_threshold_;
}

template <class S>
void MotionStepper<S>::set_explicit(double time) {
  current_.time = time;
  for (std::size_t k = 0; k < plan_.drive.linear.size(); ++k) {
    const LinearQuantity& quantity = plan_.drive.linear[k];
    const auto& [column, coefficient] = quantity.terms[0];
    const double inverse = 1 / coefficient;
    current_.y[column] = (sample_.value[k] - quantity.constant) * inverse;
    current_.dy[column] = sample_.rate[k] * inverse;
    current_.ddy[column] = sample_.acceleration[k] * inverse;
  }
}

template <class S>
bool MotionStepper<S>::newton(VectorX& y) {
  double previous_residual = INFINITY;
  for (iterations_ = 0; iterations_ <= max_newton_iterations; ++iterations_) {
    compute_poses(tree_, y.data(), state_);
    equations_.evaluate(state_, y.data(), sample_, x_.data());
    double max_residual = 0;
    for (int r = 0; r < equations_.rows(); ++r) max_residual = std::max(max_residual, std::abs(x_[r]));
    if (!std::isfinite(max_residual) || !equations_.factorise(pivot_threshold_)) return false;
    equations_.velocity_rhs(sample_, rates_.data());
    equations_.solve_pair(x_.data(), rates_.data());
    for (int c = 0; c < tree_.columns; ++c) y[c] -= x_[c];
    // Either small, or as small as round-off allows. The last correction is too small to show in the poses, but must be
    // applied: the predictor would amplify the error left without it.
    if (max_residual <= residual_tolerance_ ||
        (max_residual <= 10 * residual_tolerance_ && max_residual >= previous_residual))
      return true;
    previous_residual = max_residual;
  }
  return false;
}

/// Extrapolates, by one step, the polynomial through the last configurations and their first two derivatives: degree 2
/// from one, 5 from two, 8 from three equidistant ones. The weights are those of Hermite interpolation.
template <class S>
void MotionStepper<S>::predict(double time) {
  const double h = time - current_.time;
  const auto equidistant = [h](const CoordinateSample& a, const CoordinateSample& b) {
    return std::abs(b.time - a.time - h) <= 1e-6 * h;
  };
  const int sample_count = history_count_ < 1 || !equidistant(previous_, current_)           ? 1
                           : history_count_ < 2 || !equidistant(second_previous_, previous_) ? 2
                                                                                             : 3;
  const double hh = h * h;
  for (int c = 0; c < tree_.columns; ++c) {
    const double y = current_.y[c], v = h * current_.dy[c], a = hh * current_.ddy[c];
    if (sample_count == 1) {
      predicted_[c] = y + v + a / 2;
      continue;
    }
    const double y1 = previous_.y[c], v1 = h * previous_.dy[c], a1 = hh * previous_.ddy[c];
    if (sample_count == 2) {
      predicted_[c] = 32 * y - 31 * y1 - 16 * v - 14 * v1 + 4 * a - 2 * a1;
      continue;
    }
    const double y2 = second_previous_.y[c], v2 = h * second_previous_.dy[c], a2 = hh * second_previous_.ddy[c];
    predicted_[c] = 229.5 * y - 351 * y1 + 122.5 * y2 - 94.5 * v - 54 * v1 + 43.5 * v2 + 13.5 * a - 54 * a1 + 4.5 * a2;
  }
}

template <class S>
typename MotionStepper<S>::StepResult MotionStepper<S>::step(double time) {
  plan_.prescribed_motion->at(time, trajectory::Side::after, sample_);
  if (is_explicit_) {
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

/// Distance to the next instant [rad, characteristic lengths]: the maximum over the coordinates that affect the matrix.
/// The rates at both ends count, too, because a coordinate may reverse in between.
template <class S>
double MotionStepper<S>::step_distance(const CoordinateSample& next) const {
  const double h = next.time - current_.time;
  const std::vector<double>& scale = equations_.column_scale();
  double max_distance = 0;
  for (const ColumnId c : matrix_columns_) {
    const double rate = std::max(std::abs(current_.dy[c]), std::abs(next.dy[c]));
    max_distance = std::max(max_distance, std::max(std::abs(next.y[c] - current_.y[c]), h * rate) / scale[c]);
  }
  return max_distance;
}

/// Checks whether a monitored matrix may have been singular since the present instant. The equations are those of the
/// next one.
template <class S>
typename MotionStepper<S>::StepResult MotionStepper<S>::check_step(const CoordinateSample& next) {
  distance_ = step_distance(next);
  const double curvature =
      distance_ * distance_;  // bounds h²/8 of the second derivatives, for three rotations in a chain
  if (!(curvature <= numerics::max_matrix_curvature * equations_.regularity()) ||
      !equations_.is_near_stored(numerics::max_matrix_change))
    return StepResult::singular;
  if (regularity_monitor_ != nullptr) {
    actuation_pivot_ = regularity_monitor_->factorise(equations_);
    if (!(actuation_pivot_ >= pivot_threshold_ && curvature <= numerics::max_matrix_curvature * actuation_pivot_ &&
          regularity_monitor_->is_near_stored(numerics::max_matrix_change)))
      return StepResult::actuation_singular;
    actuation_extrapolation_.add_sample(actuation_pivot_, next.time);
  }
  motion_extrapolation_.add_sample(equations_.regularity(), next.time);
  return StepResult::done;
}

template <class S>
typename MotionStepper<S>::StepResult MotionStepper<S>::accept() {
  std::swap(second_previous_, previous_);
  std::swap(previous_, current_);
  std::swap(current_, next_);
  history_count_ = std::min(history_count_ + 1, 2);
  singularity_monitor_.sample(equations_, equations_.regularity(), actuation_pivot_, distance_);
  if (reset_spherical_references(1)) {  // same configuration, other coordinates
    if (!newton(current_.y)) return StepResult::no_convergence;
    differentiate(current_);
    history_count_ = 0;
    if (!store_matrices()) return StepResult::actuation_singular;
    singularity_monitor_.restart(equations_, equations_.regularity(), actuation_pivot_);
    return StepResult::done;
  }
  equations_.store();
  if (regularity_monitor_ != nullptr) regularity_monitor_->store();
  return StepResult::done;
}

/// Resets the reference of every spherical joint whose middle angle is beyond the limit [rad]: at a right angle its
/// coordinates are singular.
template <class S>
bool MotionStepper<S>::reset_spherical_references(double limit) {
  bool was_reset = false;
  for (const NodeId spherical : tree_.spherical_joints) {
    const double middle = std::remainder(current_.y[tree_.nodes[spherical + 1].column], 2 * std::numbers::pi);
    if (std::abs(middle) < limit) continue;
    reset_spherical_reference(tree_, spherical, current_.y.data());
    ++reference_resets_;
    was_reset = true;
  }
  return was_reset;
}

template <class S>
void MotionStepper<S>::differentiate(CoordinateSample& sample) {
  std::copy_n(rates_.data(), tree_.columns, sample.dy.data());
  compute_angular_velocities(tree_, sample.dy.data(), state_);
  if (tree_.has_sliding_closures) compute_origin_velocities(tree_, sample.dy.data(), state_);
  compute_accelerations<S>(tree_, sample.dy.data(), nullptr, S::Vector::Zero(), state_);
  equations_.acceleration_rhs(state_, sample_, x_.data());
  equations_.solve(x_.data());
  std::copy_n(x_.data(), tree_.columns, sample.ddy.data());
}

template <class S>
void MotionStepper<S>::update_accelerations(trajectory::Side side) {
  plan_.prescribed_motion->at(current_.time, side, sample_);
  if (is_explicit_) return set_explicit(current_.time);
  compute_accelerations<S>(tree_, current_.dy.data(), nullptr, S::Vector::Zero(), state_);
  equations_.acceleration_rhs(state_, sample_, x_.data());
  equations_.solve(x_.data());
  std::copy_n(x_.data(), tree_.columns, current_.ddy.data());
  if (side == trajectory::Side::after) history_count_ = 0;  // the history does not continue smoothly
}

template <class S>
bool MotionStepper<S>::advance(double time) {
  Deadline::check();
  if (is_explicit_) return step(time) == StepResult::done;
  evaluations_left_ += evaluations_per_stop;
  const double min_step =
      min_step_fraction * std::min(time - current_.time, plan_.prescribed_motion->duration() / 1024);
  double step_size = std::min(time - current_.time, next_step_size_);
  int total_iterations = 0;
  while (current_.time < time) {
    // the last step ends exactly at the requested time
    double next = time - current_.time < 1.5 * step_size ? time : current_.time + step_size;
    const double max_step = plan_.prescribed_motion->max_step(current_.time);
    if (next - current_.time > (1 + 1e-6) * max_step) next = current_.time + max_step;
    const StepResult attempt = step(next);
    total_iterations += iterations_;
    if (attempt == StepResult::done) {
      next_step_size_ = step_size *= 2;
      if (current_.time < budget_reset_time_) continue;
      budget_reset_time_ = current_.time + plan_.prescribed_motion->duration() / 1000;
      evaluations_left_ = std::max(evaluations_left_, max_evaluations);
    } else if (attempt == StepResult::evaluations_exhausted ||
               (step_size = std::min(step_size, next - current_.time) / 2) < min_step) {
      explain_stop(attempt, min_step);
      return false;
    }
  }
  iterations_ = total_iterations;
  return true;
}

template class MotionStepper<Planar>;
template class MotionStepper<Spatial>;

// Steps computed elsewhere.
template <class S>
void MotionStepper<S>::adopt_step(const CoordinateSample& next, const StepReport& report) {
  std::swap(second_previous_, previous_);
  std::swap(previous_, current_);
  current_ = next;
  history_count_ = std::min(history_count_ + 1, 2);
  iterations_ = report.iterations;
  if (is_explicit_) return;
  distance_ = report.distance;
  actuation_pivot_ = report.actuation_pivot;
  if (regularity_monitor_ != nullptr) actuation_extrapolation_.add_sample(actuation_pivot_, next.time);
  motion_extrapolation_.add_sample(report.pivot, next.time);
  singularity_monitor_.sample(equations_, report.pivot, actuation_pivot_, distance_);
}

template <class S>
void MotionStepper<S>::synchronise(bool resume) {
  plan_.prescribed_motion->at(current_.time, trajectory::Side::after, sample_);
  if (is_explicit_) return;
  compute_poses(tree_, current_.y.data(), state_);
  equations_.evaluate(state_, current_.y.data(), sample_, x_.data());
  compute_angular_velocities(tree_, current_.dy.data(), state_);
  if (tree_.has_sliding_closures) compute_origin_velocities(tree_, current_.dy.data(), state_);
  if (!resume) return;
  equations_.factorise(pivot_threshold_);
  store_matrices();
}

#define BALANCE_INSTANTIATE(S)                                                                 \
  template void MotionStepper<S>::adopt_step(const CoordinateSample& next, const StepReport&); \
  template void MotionStepper<S>::synchronise(bool);
BALANCE_INSTANTIATE(Planar)
BALANCE_INSTANTIATE(Spatial)
#undef BALANCE_INSTANTIATE

// Motion of a mechanism in which something rolls: rates are prescribed, and positions follow by integration.

namespace {

constexpr double integration_tolerance = 1e-13;  // per step, in radians or characteristic lengths

}  // namespace

/// Rates that the closures and the drive determine, at any configuration.
template <class S>
bool MotionStepper<S>::rates_at(double time, const VectorX& y, VectorX& dy) {
  if (--evaluations_left_ < 0) return false;
  trajectory::DriveSample sample;
  plan_.prescribed_motion->at(time, trajectory::Side::after, sample);
  compute_poses(tree_, y.data(), state_);
  equations_.evaluate(state_, y.data(), sample, x_.data());
  if (!y.allFinite() || !equations_.factorise(pivot_threshold_)) return false;
  equations_.velocity_rhs(sample, rates_.data());
  equations_.solve(rates_.data());
  std::copy_n(rates_.data(), tree_.columns, dy.data());
  return true;
}

/// Integrates the rates. Newton's corrections cannot replace this: they only move along admissible rates.
template <class S>
bool MotionStepper<S>::integrate(double time) {
  const VectorX scale = Eigen::Map<const VectorX>(equations_.column_scale().data(), tree_.columns);
  predicted_ = current_.y;
  const auto rates = [this](double at, const VectorX& y, VectorX& dy) { return rates_at(at, y, dy); };
  return numerics::step_by_extrapolation(rates, current_.time, time - current_.time, current_.dy, scale,
                                         integration_tolerance, predicted_);
}

#define BALANCE_INSTANTIATE(S)                                                \
  template bool MotionStepper<S>::rates_at(double, const VectorX&, VectorX&); \
  template bool MotionStepper<S>::integrate(double);
BALANCE_INSTANTIATE(Planar)
BALANCE_INSTANTIATE(Spatial)
#undef BALANCE_INSTANTIATE

// Diagnosis of a motion that cannot continue: where, and which matrix has become singular there.
template <class S>
double MotionStepper<S>::mobility() {
  if (is_explicit_) return 1;
  return equations_.min_singular_value();
}

/// Continues from the last good instant, nearer to the singular configuration than results are trusted: until steps
/// fail for good, or to the smallest pivot if the singularity is only touched. Leaves the present instant there.
template <class S>
void MotionStepper<S>::locate_singularity(StepResult attempt, double min_step) {
  const bool is_actuation = attempt == StepResult::actuation_singular;
  const double duration = plan_.prescribed_motion->duration();
  // Round-off moves a configuration by 1e-16 / pivot of the matrix that determines it, so the pivot itself is known no
  // better than this.
  pivot_threshold_ = is_actuation ? 1e-11 : 2e-8;
  evaluations_left_ = max_evaluations / 10;
  const auto pivot = [&] {
    return is_actuation ? regularity_monitor_->factorise(equations_) : equations_.regularity();
  };
  double step_size = min_step, min_pivot = INFINITY;
  CoordinateSample nearest = current_;
  while (current_.time < duration) {
    const double next = duration - current_.time < 1.5 * step_size ? duration : current_.time + step_size;
    if (step(next) == StepResult::done) {
      const double current_pivot = pivot();
      if (current_pivot > 2 * min_pivot) break;
      if (current_pivot < min_pivot) min_pivot = current_pivot, nearest = current_;
      step_size *= 2;
    } else if (evaluations_left_ < 0 || (step_size = std::min(step_size, next - current_.time) / 2) < min_step) {
      break;
    }
  }
  current_ = nearest;
}

/// Sets the outcome according to which matrix has lost rank at the last good configuration.
/// @param min_step smallest step that was attempted [s]; 0 if there was none
template <class S>
void MotionStepper<S>::explain_stop(StepResult attempt, double min_step) {
  if (min_step > 0) locate_singularity(attempt, min_step);
  const numerics::PivotExtrapolation& extrapolation =
      attempt == StepResult::actuation_singular ? actuation_extrapolation_ : motion_extrapolation_;
  const double time = std::min(extrapolation.extrapolate_zero(current_.time), plan_.prescribed_motion->duration());
  compute_poses(tree_, current_.y.data(), state_);
  std::string links = describe_collinear_links(mechanism_, tree_, state_);
  if (has_velocity_closures_ && links.empty())
    links = trajectory::describe_flat_disc(mechanism_, compute_coordinates(mechanism_, tree_, current_.y));
  const std::string configuration =
      format_configuration(mechanism_, tree_, current_.y.data()) + (links.empty() ? "" : ", where " + links);
  const auto [status, cause] = diagnose(attempt);
  if (status == MotionStatus::actuation_singularity) {
    outcome_ = trajectory::make_actuation_singularity_outcome(time, configuration);
    return;
  }
  outcome_.time = time;
  outcome_.status = status;
  outcome_.reason = trajectory::format_time_prefix(time) + cause + "; configuration: " + configuration;
}

template <class S>
std::pair<MotionStatus, const char*> MotionStepper<S>::diagnose(StepResult attempt) {
  ConstraintSystem<S> system(tree_, plan_.drive);
  MatrixX jacobian;
  plan_.prescribed_motion->at(std::min(current_.time, plan_.prescribed_motion->duration()), trajectory::Side::after,
                              sample_);
  system.velocity_jacobian(current_.y, sample_, jacobian);
  const int rank = tree_.columns - plan_.freedoms;
  const auto relative_singular_value = [](const MatrixX& matrix, int k) {
    if (k == 0 || matrix.size() == 0) return 1.0;
    const VectorX values = numerics::singular_values(matrix);
    return values[0] > 0 ? values[k - 1] / values[0] : 0.0;
  };
  const double closure_value = relative_singular_value(jacobian.topRows(tree_.closure_rows), rank);
  const double full_value =
      relative_singular_value(jacobian, std::min<int>(tree_.columns, static_cast<int>(jacobian.rows())));
  // At distance ε from a singularity the values are of order √ε. If the closures lose rank, the actuators do not hold
  // the mechanism either.
  const double threshold = attempt == StepResult::actuation_singular ? 1e-5 : 0.02;
  if (closure_value < threshold && closure_value < 10 * full_value)
    return {MotionStatus::constraint_singularity,
            "constraint singularity: the loop closures lose rank, the mechanism gains a freedom"};
  if (attempt == StepResult::actuation_singular) return {MotionStatus::actuation_singularity, ""};
  if (full_value < threshold)
    return {MotionStatus::drive_singularity,
            "drive singularity: the prescribed quantities no longer determine the motion (the path may leave the "
            "workspace here)"};
  if (attempt == StepResult::no_convergence)
    return {MotionStatus::unreachable, "the prescribed values cannot be reached"};
  if (attempt == StepResult::evaluations_exhausted)
    return {MotionStatus::unreachable,
            "the motion cannot be followed further: rates change so fast that steps shrink without end"};
  return {MotionStatus::assembly_jump, "the motion could only continue by jumping to another assembly mode"};
}

#define BALANCE_INSTANTIATE(S)                                                              \
  template double MotionStepper<S>::mobility();                                             \
  template void MotionStepper<S>::locate_singularity(MotionStepper<S>::StepResult, double); \
  template void MotionStepper<S>::explain_stop(MotionStepper<S>::StepResult, double);       \
  template std::pair<MotionStatus, const char*> MotionStepper<S>::diagnose(MotionStepper<S>::StepResult);
BALANCE_INSTANTIATE(Planar)
BALANCE_INSTANTIATE(Spatial)
#undef BALANCE_INSTANTIATE

}  // namespace balance::kinematics
