#pragma once
/// Steps of a motion in lanes: every lane from its own place in the groups before to a moment of the next one. Private to lanes.

#include "balance/lanes/actuation.hpp"
#include "balance/lanes/group_numbers.hpp"
#include "balance/motion/stepper.hpp"

#include <algorithm>
#include <limits>

namespace balance {

/// @tparam L the space S over packs
template <class L, class S>
class LaneStepper {
 public:
  using T = typename L::Scalar;

  /// @param setup must outlive it
  explicit LaneStepper(const GroupSetup<S>& setup)
      : setup_(setup),
        tree_(setup.tree),
        drive_(setup.drive),
        equations_(tree_, drive_, false),
        actuation_(setup.actuation),
        state_(tree_.nodes.size()) {
    const auto n = static_cast<std::size_t>(tree_.columns);
    for (auto* numbers : {&y_, &dy_, &ddy_, &x_, &rates_, &predicted_}) numbers->assign(n, T(0.0));
    last_y_.assign(n, 0);
    last_dy_ = last_y_;
    for (auto* values : {&sample_.value, &sample_.rate, &sample_.acceleration})
      values->setConstant(drive_.value_count(), T(0.0));
  }

  /// As GroupSolver::start.
  void start(const KinematicEquations<S>& equations, const Actuation<S>& actuation, const double* y, const double* dy) {
    if (setup_.direct) return;
    equations_.system().take_order(equations.system());
    equations_.system().store(equations.system().storage());
    actuation_.start(actuation);
    std::copy_n(y, tree_.columns, last_y_.begin());
    std::copy_n(dy, tree_.columns, last_dy_.begin());
  }

  /// The group's moments from `first` on.
  /// @return as GroupSolver::find
  bool find(GroupJob& job, int first) {
    load_prescribed_values<L>(job, first, drive_, sample_);
    if (!(setup_.direct ? solve_explicit(job, first) : solve_by_newton(job, first))) return false;
    for (int c = 0; c < tree_.columns; ++c) {
      const int at = c * group_size + first;
      y_[c].store(&job.coordinates.y[at]), dy_[c].store(&job.coordinates.dy[at]),
          ddy_[c].store(&job.coordinates.ddy[at]);
    }
    return true;
  }

  const KinematicEquations<L>& equations() const { return equations_; }  ///< filled there
  LaneActuation<L>& actuation() { return actuation_; }                   ///< looked there
  TreeState<L>& state() { return state_; }                               ///< poses and angular velocities there
  const T* dy() const { return dy_.data(); }
  const T* ddy() const { return ddy_.data(); }

 private:
  using Mask = decltype(T() < T());

  /// As Stepper::set_direct.
  bool solve_explicit(GroupJob& job, int first) {
    for (std::size_t k = 0; k < drive_.linear.size(); ++k) {
      const LinearQuantity& quantity = drive_.linear[k];
      const auto& [column, coefficient] = quantity.terms[0];
      const double inverse = 1 / coefficient;
      y_[column] = (sample_.value[k] - quantity.constant) * inverse;
      dy_[column] = sample_.rate[k] * inverse;
      ddy_[column] = sample_.acceleration[k] * inverse;
    }
    compute_poses(tree_, y_.data(), state_);
    compute_angular_velocities(tree_, dy_.data(), state_);
    for (int l = first; l < first + T::lanes; ++l) job.pivot[l] = job.hold_pivot[l] = 1, job.iterations[l] = 0;
    return true;
  }

  bool solve_by_newton(GroupJob& job, int first) {
    predict_group(job, first, predicted_);
    y_ = predicted_;
    T iterations;
    if (!newton(iterations) || !is_near_prediction()) return false;
    differentiate();
    const T hold_pivot = actuation_.factorise(equations_);
    if (!(reduce_min(hold_pivot) >= singular_pivot_threshold)) return false;
    if (!equations_.is_near_stored(max_matrix_change) || !actuation_.near_kept(max_matrix_change)) return false;
    equations_.system().min_pivot().store(&job.pivot[first]);
    hold_pivot.store(&job.hold_pivot[first]);
    step_distance(job.step).store(&job.distance[first]);
    iterations.store(&job.iterations[first]);
    equations_.store();
    actuation_.keep();
    for (int c = 0; c < tree_.columns; ++c) last_y_[c] = y_[c][T::lanes - 1], last_dy_[c] = dy_[c][T::lanes - 1];
    return true;
  }

  /// As Stepper::newton. A lane that is done stays where it was before its last correction, so that everything is evaluated there
  /// again, to the same bits, until the others are done, too.
  bool newton(T& iterations) {
    constexpr double inf = std::numeric_limits<double>::infinity();
    const double enough = setup_.residual_tolerance;
    T last = inf;
    Mask done = last < 0.0;
    iterations = 0.0;
    for (int count = 0; count <= MotionStepper<S>::max_newton_iterations; ++count) {
      compute_poses(tree_, y_.data(), state_);
      equations_.evaluate(state_, y_.data(), sample_, x_.data());
      T worst = 0.0;
      for (const T& x : x_) worst = max(worst, abs(x));
      if (!all(worst < inf) || !equations_.factorise()) return false;
      equations_.velocity_rhs(sample_, rates_.data());
      equations_.solve_pair(x_.data(), rates_.data());
      const Mask before = done;
      done = done | (worst <= enough) | ((worst <= 10 * enough) & (worst >= last));
      iterations = select(before, iterations, T(count));
      last = worst;
      const bool finished = all(done);
      for (int c = 0; c < tree_.columns; ++c) y_[c] = finished ? y_[c] - x_[c] : select(done, y_[c], y_[c] - x_[c]);
      if (finished) return true;
    }
    return false;
  }

  bool is_near_prediction() const {
    const std::vector<double>& scale = equations_.column_scale();
    for (int c = 0; c < tree_.columns; ++c)
      if (!all(abs(y_[c] - predicted_[c]) <= MotionStepper<S>::max_correction * scale[c])) return false;
    return true;
  }

  void differentiate() {
    dy_ = rates_;
    compute_angular_velocities(tree_, dy_.data(), state_);
    if (tree_.has_sliding_closures) compute_origin_velocities(tree_, dy_.data(), state_);
    compute_accelerations<L>(tree_, dy_.data(), nullptr, L::Vector::Zero(), state_);
    equations_.acceleration_rhs(state_, sample_, x_.data());
    equations_.solve(x_.data());
    ddy_ = x_;
  }

  /// As Stepper::turned, of every moment since the one before it.
  T step_distance(double h) const {
    const std::vector<double>& scale = equations_.column_scale();
    T most = 0.0;
    for (const int c : setup_.matrix_columns) {
      const T rate = max(abs(shift_lanes(dy_[c], last_dy_[c])), abs(dy_[c]));
      most = max(most, max(abs(y_[c] - shift_lanes(y_[c], last_y_[c])), h * rate) / scale[c]);
    }
    return most;
  }

  const GroupSetup<S>& setup_;
  const Tree<S>& tree_;
  const Drive<S>& drive_;
  KinematicEquations<L> equations_;
  LaneActuation<L> actuation_;
  TreeState<L> state_;
  DriveSampleOf<T> sample_;
  std::vector<T> y_, dy_, ddy_, x_, rates_, predicted_;
  std::vector<double> last_y_, last_dy_;  ///< of the moment before the first lane's
};

}  // namespace balance
