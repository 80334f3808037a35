#pragma once
/// Steps of a motion in lanes: each lane steps from its own instants in the previous groups to one instant of the next
/// group.

#include "balance/foundation/numerics/lane_block_triangular.hpp"
#include "balance/mechanics/dynamics/actuation.hpp"
#include "balance/mechanics/dynamics/sample_quantities.hpp"
#include "balance/mechanics/kinematics/drive.hpp"
#include "balance/mechanics/kinematics/motion_stepper.hpp"
#include "balance/mechanics/lanes/lane_kernels.hpp"
#include "balance/mechanics/lanes/lane_min_singular_value.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <vector>

namespace balance::lanes {

// Efforts and multipliers by the square system of Actuation, one sample per lane.

/// @tparam L a space over packs
template <class L>
class LaneActuation {
 public:
  using T = typename L::Scalar;

  /// @param scalar regular, and factorised before
  template <class S>
  explicit LaneActuation(const dynamics::Actuation<S>& scalar)
      : closures_(scalar.closures_), passive_columns_(scalar.passive_columns_) {
    for (const auto& motor : scalar.actuated_) motors_.push_back({motor.column, motor.ratio, {}});
    for (const auto& entry : scalar.closure_entries_) passive_entries_.push_back({entry.storage_index, entry.index});
    for (std::size_t a = 0; a < scalar.motor_column_entries_.size(); ++a)
      for (const auto& entry : scalar.motor_column_entries_[a])
        motors_[a].entries.push_back({entry.storage_index, entry.row});
    numerics::SparsityPattern pattern(static_cast<std::size_t>(closures_));
    for (const auto& entry : scalar.closure_entries_) pattern[entry.row].push_back(position(entry.column));
    passive_.analyse(pattern);
    efforts_.assign(motors_.size(), T(0.0));
    multipliers_.assign(static_cast<std::size_t>(closures_), T(0.0));
  }

  /// Takes the matrix that precedes the first lane, and the order of pivots, from the scalar object's last
  /// factorisation.
  template <class S>
  void start(const dynamics::Actuation<S>& scalar) {
    if (closures_ == 0) return;
    passive_.take_order(scalar.passive_);
    passive_.store(scalar.passive_.storage());
  }

  /// @return the smallest pivot per lane; see Actuation::factorise
  T factorise(const kinematics::KinematicEquations<L>& equations) {
    if (closures_ == 0) return 1.0;
    for (const EntryCopy& entry : passive_entries_) passive_.storage()[entry.to] = equations.entry_at(entry.from);
    passive_.factorise();
    return passive_.min_pivot();
  }
  bool is_near_stored(double limit) { return closures_ == 0 || passive_.is_near_stored(limit); }
  void store() {
    if (closures_ > 0) passive_.store();
  }

  /// @pre factorise() found regular matrices @param tau per tree coordinate
  void solve(const kinematics::KinematicEquations<L>& equations, const T* tau) {
    const std::vector<double>&columns = equations.column_scale(), &rows = equations.row_scale();
    for (int k = 0; k < closures_; ++k) multipliers_[k] = columns[passive_columns_[k]] * tau[passive_columns_[k]];
    if (closures_ > 0) passive_.solve_transposed(multipliers_.data());
    for (std::size_t a = 0; a < motors_.size(); ++a) {
      const Motor& motor = motors_[a];
      T sum = 0.0;
      for (const EntryCopy& entry : motor.entries) sum += equations.entry_at(entry.from) * multipliers_[entry.to];
      efforts_[a] = (tau[motor.column] - sum / columns[motor.column]) / motor.ratio;
    }
    for (int r = 0; r < closures_; ++r) multipliers_[r] *= rows[r];
  }

  const std::vector<T>& efforts() const { return efforts_; }          ///< per actuator [N m or N]
  const std::vector<T>& multipliers() const { return multipliers_; }  ///< per closure row [N or N m]

 private:
  struct EntryCopy {
    int from;  ///< index among the equations' values
    int to;    ///< index in the passive matrix, or the row
  };
  struct Motor {
    kinematics::ColumnId column;
    double ratio;
    std::vector<EntryCopy> entries;
  };

  int position(kinematics::ColumnId column) const {
    return static_cast<int>(std::find(passive_columns_.begin(), passive_columns_.end(), column) -
                            passive_columns_.begin());
  }

  int closures_;
  std::vector<kinematics::ColumnId> passive_columns_;
  std::vector<Motor> motors_;
  std::vector<EntryCopy> passive_entries_;
  numerics::LaneSquareSystem<T::lanes> passive_;
  std::vector<T> efforts_, multipliers_;
};

// Conversion of a GroupJob's arrays to lanes.

/// Loads the prescribed values at the instants from `first` on.
template <class L>
void load_prescribed_values(const GroupJob& job, int first, const kinematics::Drive<kinematics::Constants<L>>& drive,
                            trajectory::DriveSampleOf<typename L::Scalar>& sample) {
  using T = typename L::Scalar;
  for (int k = 0; k < drive.value_count(); ++k) {
    const int index = k * group_size + first;
    sample.value[k] = T::load(&job.value[index]);
    sample.rate[k] = T::load(&job.rate[index]);
    sample.acceleration[k] = T::load(&job.acceleration[index]);
  }
  if (drive.rotation.empty()) return;
  for (int k = 0; k < 9; ++k) sample.rotation(k % 3, k / 3) = T::load(&job.rotation[k * group_size + first]);
  for (int k = 0; k < 3; ++k) {
    sample.angular_velocity[k] = T::load(&job.angular_velocity[k * group_size + first]);
    sample.angular_acceleration[k] = T::load(&job.angular_acceleration[k * group_size + first]);
  }
}

/// Predicts the instants from `first` on, as MotionStepper::predict, from the same instants of the previous groups.
template <class T>
void predict_group(const GroupJob& job, int first, std::vector<T>& y_next) {
  const double h = job.step * group_size, hh = h * h;
  const auto load_entry = [&](int group, std::vector<double> GroupCoordinates::*numbers, int c) {
    return T::load(&(job.history[group]->*numbers)[c * group_size + first]);
  };
  for (int c = 0; c < static_cast<int>(y_next.size()); ++c) {
    const T y = load_entry(0, &GroupCoordinates::y, c), v = h * load_entry(0, &GroupCoordinates::dy, c),
            a = hh * load_entry(0, &GroupCoordinates::ddy, c);
    if (job.history_count < 2) {
      y_next[c] = y + v + 0.5 * a;
      continue;
    }
    const T y1 = load_entry(1, &GroupCoordinates::y, c), v1 = h * load_entry(1, &GroupCoordinates::dy, c),
            a1 = hh * load_entry(1, &GroupCoordinates::ddy, c);
    if (job.history_count < 3) {
      y_next[c] = 32.0 * y - 31.0 * y1 - 16.0 * v - 14.0 * v1 + 4.0 * a - 2.0 * a1;
      continue;
    }
    const T y2 = load_entry(2, &GroupCoordinates::y, c), v2 = h * load_entry(2, &GroupCoordinates::dy, c),
            a2 = hh * load_entry(2, &GroupCoordinates::ddy, c);
    y_next[c] =
        229.5 * y - 351.0 * y1 + 122.5 * y2 - 94.5 * v - 54.0 * v1 + 43.5 * v2 + 13.5 * a - 54.0 * a1 + 4.5 * a2;
  }
}

// The results of a SampleEvaluator, one instant per lane.

/// @tparam L the space S over packs
template <class L, class S>
class LaneSampleEvaluator {
 public:
  using T = typename L::Scalar;

  explicit LaneSampleEvaluator(const GroupSetup<S>& setup)
      : mechanism_(setup.mechanism),
        tree_(setup.tree),
        tool_(setup.drive.tool),
        gravity_(kinematics::to_vector<S>(mechanism_.gravity).template cast<T>()),
        about_(setup.about.template cast<T>()),
        wrenches_(tree_.nodes.size()),
        tau_(static_cast<std::size_t>(tree_.columns)) {
    sample_.joint_force.assign(mechanism_.joints.size(), Vector3Of<T>::Zero());
    sample_.joint_moment = sample_.joint_force;
  }

  /// @param equations evaluated and actuation factorised there; the state holds poses and angular velocities
  void evaluate(const kinematics::KinematicEquations<L>& equations, LaneActuation<L>& actuation,
                kinematics::TreeState<L>& state, const T* dy, const T* ddy) {
    compute_origin_velocities(tree_, dy, state);
    kinematics::compute_accelerations<L>(tree_, dy, ddy, -gravity_, state);
    for (auto& wrench : wrenches_) wrench = {};
    inverse_dynamics(tree_, state, wrenches_, tau_.data());
    actuation.solve(equations, tau_.data());
    efforts_ = actuation.efforts().data();
    const dynamics::Wrench<L> no_wrench;
    dynamics::compute_total_forces<L>(tree_, state, {wrenches_[0], no_wrench, no_wrench, gravity_, about_}, sample_);
    if (mechanism_.tool) {
      sample_.tool_position = kinematics::to_3d(position(state, tool_));
      sample_.tool_rotation = to_matrix(orientation(state, tool_));
    }
    sample_.com_velocity = kinematics::to_3d(com_velocity(tree_, state));
    dynamics::compute_energies(tree_, state, gravity_, T(0.0), sample_);
    if (!tree_.closures.empty()) {
      for (auto& wrench : wrenches_) wrench = {};
      add_closure_wrenches(tree_, state, actuation.multipliers(), wrenches_, sample_);
      inverse_dynamics(tree_, state, wrenches_, tau_.data());
    }
    compute_joint_reactions(mechanism_, tree_, state, wrenches_, sample_);
  }

  /// Stores the instants of all lanes in the samples from `first` on.
  template <std::size_t N>
  void store(const T& mobility, int first, std::array<Sample, N>& samples) const {
    for (int l = 0; l < T::lanes; ++l) {
      Sample& out = samples[static_cast<std::size_t>(first) + static_cast<std::size_t>(l)];
      const auto copy = [l](const auto& in, auto& to) {
        for (Eigen::Index i = 0; i < in.size(); ++i) to.data()[i] = in.data()[i][l];
      };
      for (Eigen::Index a = 0; a < out.effort.size(); ++a) out.effort[a] = efforts_[a][l];
      copy(sample_.com, out.com);
      copy(sample_.com_velocity, out.com_velocity);
      copy(sample_.com_acceleration, out.com_acceleration);
      copy(sample_.tool_position, out.tool_position);
      copy(sample_.tool_rotation, out.tool_rotation);
      copy(sample_.shaking_force, out.shaking_force);
      copy(sample_.shaking_moment, out.shaking_moment);
      copy(sample_.ground_force, out.ground_force);
      copy(sample_.ground_moment, out.ground_moment);
      for (std::size_t j = 0; j < out.joint_force.size(); ++j) {
        copy(sample_.joint_force[j], out.joint_force[j]);
        copy(sample_.joint_moment[j], out.joint_moment[j]);
      }
      out.kinetic_energy = sample_.kinetic_energy[l];
      out.potential_energy = sample_.potential_energy[l];
      out.mobility = mobility[l];
    }
  }

 private:
  const Mechanism& mechanism_;
  const kinematics::Tree<S>& tree_;
  const kinematics::FixedFrame<S>& tool_;
  typename L::Vector gravity_, about_;
  std::vector<dynamics::Wrench<L>> wrenches_;
  std::vector<T> tau_;
  const T* efforts_ = nullptr;  ///< per actuator
  trajectory::SampleOf<T> sample_;
};

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
  void start(const kinematics::KinematicEquations<S>& equations, const dynamics::Actuation<S>& actuation,
             const double* y, const double* dy) {
    if (setup_.direct) return;
    equations_.system().take_order(equations.system());
    equations_.system().store(equations.system().storage());
    actuation_.start(actuation);
    std::copy_n(y, tree_.columns, last_y_.begin());
    std::copy_n(dy, tree_.columns, last_dy_.begin());
  }

  /// Solves the group's instants from `first` on.
  /// @return as GroupSolver::solve
  bool find(GroupJob& job, int first) {
    load_prescribed_values<L>(job, first, drive_, sample_);
    if (!(setup_.direct ? solve_explicit(job, first) : solve_by_newton(job, first))) return false;
    for (int c = 0; c < tree_.columns; ++c) {
      const int index = c * group_size + first;
      y_[c].store(&job.coordinates.y[index]), dy_[c].store(&job.coordinates.dy[index]),
          ddy_[c].store(&job.coordinates.ddy[index]);
    }
    return true;
  }

  const kinematics::KinematicEquations<L>& equations() const { return equations_; }  ///< evaluated there
  LaneActuation<L>& actuation() { return actuation_; }                               ///< factorised there
  kinematics::TreeState<L>& state() { return state_; }  ///< poses and angular velocities there
  const T* dy() const { return dy_.data(); }
  const T* ddy() const { return ddy_.data(); }

 private:
  using Mask = decltype(T() < T());

  /// As MotionStepper::set_explicit.
  bool solve_explicit(GroupJob& job, int first) {
    for (std::size_t k = 0; k < drive_.linear.size(); ++k) {
      const kinematics::LinearQuantity& quantity = drive_.linear[k];
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
    const T actuation_pivot = actuation_.factorise(equations_);
    if (!(reduce_min(actuation_pivot) >= numerics::singular_pivot_threshold)) return false;
    if (!equations_.is_near_stored(numerics::max_matrix_change) ||
        !actuation_.is_near_stored(numerics::max_matrix_change))
      return false;
    equations_.system().min_pivot().store(&job.pivot[first]);
    actuation_pivot.store(&job.hold_pivot[first]);
    step_distance(job.step).store(&job.distance[first]);
    iterations.store(&job.iterations[first]);
    equations_.store();
    actuation_.store();
    for (int c = 0; c < tree_.columns; ++c) last_y_[c] = y_[c][T::lanes - 1], last_dy_[c] = dy_[c][T::lanes - 1];
    return true;
  }

  /// As MotionStepper::newton. A converged lane stays where it was before its last correction, so that it is evaluated
  /// there again, with bitwise identical results, until the other lanes have converged, too.
  bool newton(T& iterations) {
    constexpr double inf = std::numeric_limits<double>::infinity();
    const double tolerance = setup_.residual_tolerance;
    T previous_residual = inf;
    Mask converged = previous_residual < 0.0;
    iterations = 0.0;
    for (int count = 0; count <= kinematics::MotionStepper<S>::max_newton_iterations; ++count) {
      compute_poses(tree_, y_.data(), state_);
      equations_.evaluate(state_, y_.data(), sample_, x_.data());
      T max_residual = 0.0;
      for (const T& x : x_) max_residual = max(max_residual, abs(x));
      if (!all(max_residual < inf) || !equations_.factorise()) return false;
      equations_.velocity_rhs(sample_, rates_.data());
      equations_.solve_pair(x_.data(), rates_.data());
      const Mask was_converged = converged;
      converged = converged | (max_residual <= tolerance) |
                  ((max_residual <= 10 * tolerance) & (max_residual >= previous_residual));
      iterations = select(was_converged, iterations, T(count));
      previous_residual = max_residual;
      const bool all_converged = all(converged);
      for (int c = 0; c < tree_.columns; ++c)
        y_[c] = all_converged ? y_[c] - x_[c] : select(converged, y_[c], y_[c] - x_[c]);
      if (all_converged) return true;
    }
    return false;
  }

  bool is_near_prediction() const {
    const std::vector<double>& scale = equations_.column_scale();
    for (int c = 0; c < tree_.columns; ++c)
      if (!all(abs(y_[c] - predicted_[c]) <= kinematics::MotionStepper<S>::max_correction * scale[c])) return false;
    return true;
  }

  void differentiate() {
    dy_ = rates_;
    compute_angular_velocities(tree_, dy_.data(), state_);
    if (tree_.has_sliding_closures) compute_origin_velocities(tree_, dy_.data(), state_);
    kinematics::compute_accelerations<L>(tree_, dy_.data(), nullptr, L::Vector::Zero(), state_);
    equations_.acceleration_rhs(state_, sample_, x_.data());
    equations_.solve(x_.data());
    ddy_ = x_;
  }

  /// As MotionStepper::step_distance, for every instant since the one before it.
  T step_distance(double h) const {
    const std::vector<double>& scale = equations_.column_scale();
    T max_distance = 0.0;
    for (const int c : setup_.matrix_columns) {
      const T rate = max(abs(shift_lanes(dy_[c], last_dy_[c])), abs(dy_[c]));
      max_distance = max(max_distance, max(abs(y_[c] - shift_lanes(y_[c], last_y_[c])), h * rate) / scale[c]);
    }
    return max_distance;
  }

  const GroupSetup<S>& setup_;
  const kinematics::Tree<S>& tree_;
  const kinematics::Drive<S>& drive_;
  kinematics::KinematicEquations<L> equations_;
  LaneActuation<L> actuation_;
  kinematics::TreeState<L> state_;
  trajectory::DriveSampleOf<T> sample_;
  std::vector<T> y_, dy_, ddy_, x_, rates_, predicted_;
  std::vector<double> last_y_, last_dy_;  ///< of the instant before the first lane's
};

// A GroupSolver in lanes: solves a group part by part, with as many instants per part as the instruction set has lanes.

/// @tparam L the space S over packs
template <class L, class S>
class LaneGroupSolver final : public GroupSolver<S> {
 public:
  explicit LaneGroupSolver(const GroupSetup<S>& setup)
      : setup_(setup), stepper_(setup_), min_singular_value_(stepper_.equations()), evaluator_(setup_) {}

  void start(const kinematics::KinematicEquations<S>& equations, const dynamics::Actuation<S>& actuation,
             const double* y, const double* dy) override {
    stepper_.start(equations, actuation, y, dy);
  }

  bool solve(GroupJob& job) override {
    using T = typename L::Scalar;
    for (int first = 0; first < group_size; first += T::lanes) {
      if (!stepper_.find(job, first)) return false;
      evaluator_.evaluate(stepper_.equations(), stepper_.actuation(), stepper_.state(), stepper_.dy(), stepper_.ddy());
      evaluator_.store(setup_.direct ? T(1.0) : min_singular_value_.compute(stepper_.equations()), first, job.samples);
    }
    return true;
  }

 private:
  GroupSetup<S> setup_;
  LaneStepper<L, S> stepper_;
  LaneMinSingularValue<L> min_singular_value_;
  LaneSampleEvaluator<L, S> evaluator_;
};

}  // namespace balance::lanes
