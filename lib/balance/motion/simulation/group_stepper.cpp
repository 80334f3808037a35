#include "balance/motion/simulation/group_stepper.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace balance::simulation {

namespace {

/// Smaller pivots are left to the stepper, which then examines how near to a singularity the motion comes.
constexpr double min_group_pivot = 8 * numerics::near_singular_pivot_threshold;
constexpr double max_middle_angle =
    0.99;  // of a spherical joint's middle angle [rad]; the stepper resets the reference from 1 on
constexpr int max_backoff = 63;

std::unique_ptr<lanes::GroupSolver<kinematics::Planar>> make_group_solver(
    InstructionSet instruction_set, const lanes::GroupSetup<kinematics::Planar>& setup) {
  return lanes::lane_kernels(instruction_set).planar_motion(setup);
}
std::unique_ptr<lanes::GroupSolver<kinematics::Spatial>> make_group_solver(
    InstructionSet instruction_set, const lanes::GroupSetup<kinematics::Spatial>& setup) {
  return lanes::lane_kernels(instruction_set).spatial_motion(setup);
}

}  // namespace

template <class S>
GroupStepper<S>::GroupStepper(dynamics::TreeMotionSource<S>& source, long samples, InstructionSet instruction_set)
    : source_(source),
      tree_(source.tree()),
      plan_(source.plan()),
      stepper_(source.stepper()),
      observer_(source.evaluator()),
      times_{plan_.prescribed_motion->duration(), samples},
      instruction_set_(instruction_set),
      is_explicit_(stepper_.is_explicit()),
      can_use_groups_(!plan_.has_redundant_closures && tree_.position_rows == tree_.closure_rows &&
                      !stepper_.equations().structurally_singular() && tree_.columns > 0 &&
                      tree_.columns <= numerics::max_dense_columns && observer_.can_use_lanes()),
      sample_(&observer_.sample()) {
  groups_.fill(lanes::GroupCoordinates(tree_.columns));
  job_.coordinates = lanes::GroupCoordinates(tree_.columns);
  for (auto* numbers : {&job_.value, &job_.rate, &job_.acceleration})
    numbers->resize(static_cast<std::size_t>(plan_.drive.value_count()) * lanes::group_size);
  job_.rotation.resize(std::size_t{9} * lanes::group_size);
  for (auto* numbers : {&job_.angular_velocity, &job_.angular_acceleration})
    numbers->resize(std::size_t{3} * lanes::group_size);
  job_.samples.fill(observer_.sample());
  for (VectorX* values : {&coordinate_sample_.y, &coordinate_sample_.dy, &coordinate_sample_.ddy})
    values->setZero(tree_.columns);
}

template <class S>
bool GroupStepper<S>::begin() {
  if (!source_.begin()) return false;
  restart();
  step_ = 1;
  is_at_even_step_ = true;
  record_step();
  return true;
}

template <class S>
bool GroupStepper<S>::advance(double time) {
  is_at_even_step_ = step_ <= times_.steps && time == times_.time_of(step_);
  if (next_in_group_ == lanes::group_size && is_at_even_step_ && try_group()) next_in_group_ = 0;
  in_group_ = next_in_group_ < lanes::group_size;
  if (in_group_) {
    adopt_next();
    return true;
  }
  synchronise_stepper();
  const int references = stepper_.reference_resets();
  if (!source_.advance(time)) return false;
  if (stepper_.reference_resets() != references) {  // neither previous coordinates nor the tree are comparable any more
    restart();
    group_solver_.reset();
  }
  record_step();
  if (is_at_even_step_) ++step_;
  return true;
}

template <class S>
void GroupStepper<S>::update_accelerations(trajectory::Side side) {
  synchronise_stepper();
  in_group_ = false;
  stepper_.update_accelerations(side);
  if (side == trajectory::Side::before) return;
  restart();
  record_step();
}

template <class S>
bool GroupStepper<S>::update_payloads() {
  if (!source_.update_payloads()) return false;
  group_solver_.reset();
  is_solver_started_ = false;
  return true;
}

/// The motion does not continue smoothly at the current moment: discards the history.
template <class S>
void GroupStepper<S>::restart() {
  history_count_ = recorded_count_ = 0;
  is_solver_started_ = false;
}

template <class S>
void GroupStepper<S>::synchronise_stepper() {
  if (is_stepper_behind_) stepper_.synchronise(true);
  is_stepper_behind_ = is_solver_started_ = false;
}

/// Records the stepper's current moment in the group that it is making.
template <class S>
void GroupStepper<S>::record_step() {
  if (!can_use_groups_ || !is_at_even_step_) return;
  lanes::GroupCoordinates& current_group = groups_[0];
  for (int c = 0; c < tree_.columns; ++c) {
    const int index = c * lanes::group_size + recorded_count_;
    current_group.y[index] = stepper_.y()[c], current_group.dy[index] = stepper_.dy()[c],
    current_group.ddy[index] = stepper_.ddy()[c];
  }
  if (++recorded_count_ < lanes::group_size) return;
  std::rotate(groups_.begin(), groups_.end() - 1, groups_.end());
  history_count_ = std::min(history_count_ + 1, 3);
  recorded_count_ = 0;
}

template <class S>
bool GroupStepper<S>::try_group() {
  if (!can_use_groups_ || history_count_ == 0 || recorded_count_ > 0 || step_ + lanes::group_size - 1 > times_.steps)
    return false;
  const std::vector<double>& jumps = plan_.prescribed_motion->jump_times();
  const auto jump = std::upper_bound(jumps.begin(), jumps.end(), time() + 1e-9 * times_.duration);
  if (jump != jumps.end() && *jump <= times_.time_of(step_ + lanes::group_size - 1) + 1e-9 * times_.duration)
    return false;
  if (remaining_skips_ > 0) {
    --remaining_skips_;
    return false;
  }
  if (solve_group()) {
    backoff_ = 0;
    return true;
  }
  remaining_skips_ = backoff_ = std::min(2 * backoff_ + 1, max_backoff);
  is_solver_started_ = false;
  return false;
}

template <class S>
bool GroupStepper<S>::solve_group() {
  if (!sample_drive(time())) return false;
  if (!group_solver_) {
    group_solver_ = make_group_solver(
        instruction_set_,
        lanes::GroupSetup<S>{source_.mechanism(), tree_, plan_.drive, observer_.actuation(), source_.about(),
                             stepper_.residual_tolerance(), stepper_.matrix_columns(), is_explicit_});
    is_solver_started_ = false;
  }
  if (!is_solver_started_) {
    if (is_stepper_behind_) stepper_.synchronise(true), is_stepper_behind_ = false;
    group_solver_->start(stepper_.equations(), observer_.actuation(), stepper_.y(), stepper_.dy());
  }
  job_.step = times_.duration / static_cast<double>(times_.steps);
  job_.history_count = history_count_;
  for (int k = 0; k < history_count_; ++k)
    job_.history[static_cast<std::size_t>(k)] = &groups_[static_cast<std::size_t>(k) + 1];
  if (!group_solver_->solve(job_) || !is_accepted()) return false;
  is_solver_started_ = true;
  return true;
}

/// @param before time of the current moment
/// @return false if the drive needs shorter steps
template <class S>
bool GroupStepper<S>::sample_drive(double before) {
  const auto scatter = [](const auto& from, int l, std::vector<double>& to) {
    for (Eigen::Index k = 0; k < from.size(); ++k)
      to[static_cast<std::size_t>(k * lanes::group_size + l)] = from.data()[k];
  };
  for (int l = 0; l < lanes::group_size; ++l) {
    const double time = times_.time_of(step_ + l);
    if (!is_explicit_ && time - before > (1 + 1e-6) * plan_.prescribed_motion->max_step(before)) return false;
    plan_.prescribed_motion->at(time, trajectory::Side::after, drive_);
    scatter(drive_.value, l, job_.value);
    scatter(drive_.rate, l, job_.rate);
    scatter(drive_.acceleration, l, job_.acceleration);
    if (!plan_.drive.rotation.empty()) {
      scatter(drive_.rotation, l, job_.rotation);
      scatter(drive_.angular_velocity, l, job_.angular_velocity);
      scatter(drive_.angular_acceleration, l, job_.angular_acceleration);
    }
    group_times_[static_cast<std::size_t>(l)] = before = time;
  }
  return true;
}

/// Like MotionStepper::check_step; in addition, no spherical joint may need a new reference.
template <class S>
bool GroupStepper<S>::is_accepted() const {
  if (is_explicit_) return true;
  for (std::size_t l = 0; l < lanes::group_size; ++l) {
    const double pivot = std::min(job_.pivot[l], job_.hold_pivot[l]);
    if (!(pivot >= min_group_pivot && job_.distance[l] * job_.distance[l] <= numerics::max_matrix_curvature * pivot))
      return false;
    for (const kinematics::NodeId spherical : tree_.spherical_joints) {
      const auto column = static_cast<std::size_t>(tree_.nodes[static_cast<std::size_t>(spherical) + 1].column);
      const double middle = std::remainder(job_.coordinates.y[column * lanes::group_size + l], 2 * std::numbers::pi);
      if (!(std::abs(middle) < max_middle_angle)) return false;
    }
  }
  return true;
}

/// Moves to the next moment of the computed group.
template <class S>
void GroupStepper<S>::adopt_next() {
  const auto l = static_cast<std::size_t>(next_in_group_);
  for (int c = 0; c < tree_.columns; ++c) {
    const std::size_t index = static_cast<std::size_t>(c) * lanes::group_size + l;
    coordinate_sample_.y[c] = job_.coordinates.y[index], coordinate_sample_.dy[c] = job_.coordinates.dy[index],
    coordinate_sample_.ddy[c] = job_.coordinates.ddy[index];
  }
  coordinate_sample_.time = group_times_[l];
  stepper_.adopt_step(coordinate_sample_, {.pivot = job_.pivot[l],
                                           .actuation_pivot = job_.hold_pivot[l],
                                           .distance = job_.distance[l],
                                           .iterations = static_cast<int>(job_.iterations[l])});
  is_stepper_behind_ = true;
  ++group_step_count_;
  ++step_;
  if (++next_in_group_ < lanes::group_size) return;
  std::swap(groups_[0], job_.coordinates);
  std::rotate(groups_.begin(), groups_.end() - 1, groups_.end());
  history_count_ = std::min(history_count_ + 1, 3);
}

template <class S>
bool GroupStepper<S>::evaluate() {
  Sample& sample = in_group_ ? job_.samples[static_cast<std::size_t>(next_in_group_ - 1)] : observer_.sample();
  sample_ = &sample;
  if (in_group_) {
    sample.time = time();
    observer_.complete_sample(stepper_.y(), stepper_.dy(), stepper_.ddy(), sample);
  } else {
    if (!source_.evaluate()) return false;
    sample.mobility = stepper_.mobility();
  }
  sample.newton_iterations = stepper_.iterations();
  return true;
}

template <class S>
dynamics::TreeMotion<S> GroupStepper<S>::at_current_sample() {
  if (in_group_) {
    stepper_.synchronise(false);
    observer_.evaluate(stepper_, dynamics::Detail::all);
  }
  return {stepper_.state(), stepper_.y(), stepper_.dy(), stepper_.ddy(), stepper_.time(), stepper_.is_explicit()};
}

template class GroupStepper<kinematics::Planar>;
template class GroupStepper<kinematics::Spatial>;

}  // namespace balance::simulation
