#include "balance/motion/simulation/group_stepper.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace balance {

namespace {

/// Smaller pivots are the stepper's: it then looks at how near to a singularity the motion comes.
constexpr double min_group_pivot = 8 * near_singular_pivot_threshold;
constexpr double max_middle_angle =
    0.99;  // of a spherical joint's angles [rad]; the stepper counts them anew from 1 on
constexpr int max_backoff = 63;

std::unique_ptr<GroupSolver<Planar>> make_motion(InstructionSet set, const GroupSetup<Planar>& setup) {
  return lane_kernels(set).planar_motion(setup);
}
std::unique_ptr<GroupSolver<Spatial>> make_motion(InstructionSet set, const GroupSetup<Spatial>& setup) {
  return lane_kernels(set).spatial_motion(setup);
}

}  // namespace

template <class S>
GroupStepper<S>::GroupStepper(const Mechanism& mechanism, const Tree<S>& tree, const CompiledTrajectory<S>& plan,
                              const TimeGrid& times, const typename S::Vector& about, MotionStepper<S>& stepper,
                              SampleEvaluator<S>& observer, InstructionSet set)
    : mechanism_(mechanism),
      tree_(tree),
      plan_(plan),
      times_(times),
      about_(about),
      stepper_(stepper),
      observer_(observer),
      set_(set),
      direct_(stepper.is_explicit()),
      can_use_groups_(!plan.has_redundant_closures && tree.position_rows == tree.closure_rows &&
                      !stepper.equations().structurally_singular() && tree.columns > 0 &&
                      tree.columns <= max_dense_columns && observer.can_use_lanes()) {
  groups_.fill(GroupCoordinates(tree.columns));
  job_.coordinates = GroupCoordinates(tree.columns);
  for (auto* numbers : {&job_.value, &job_.rate, &job_.acceleration})
    numbers->resize(static_cast<std::size_t>(plan.drive.value_count()) * group_size);
  job_.rotation.resize(std::size_t{9} * group_size);
  for (auto* numbers : {&job_.angular_velocity, &job_.angular_acceleration})
    numbers->resize(std::size_t{3} * group_size);
  job_.samples.fill(observer.sample());
  for (VectorX* values : {&moment_.y, &moment_.dy, &moment_.ddy}) values->setZero(tree.columns);
}

template <class S>
bool GroupStepper<S>::begin() {
  if (!stepper_.begin()) return false;
  restart();
  step_ = 1;
  on_time_ = true;
  record_step();
  return true;
}

template <class S>
bool GroupStepper<S>::advance(double time) {
  on_time_ = step_ <= times_.steps && time == times_.time_of(step_);
  if (next_in_group_ == group_size && on_time_ && try_group()) next_in_group_ = 0;
  in_group_ = next_in_group_ < group_size;
  if (in_group_) {
    adopt_next();
    return true;
  }
  synchronise_stepper();
  const int references = stepper_.reference_resets();
  if (!stepper_.advance(time)) return false;
  if (stepper_.reference_resets() != references) {  // coordinates before are not comparable, nor is the tree
    restart();
    motion_.reset();
  }
  record_step();
  if (on_time_) ++step_;
  return true;
}

template <class S>
void GroupStepper<S>::update_accelerations(Side side) {
  synchronise_stepper();
  in_group_ = false;
  stepper_.update_accelerations(side);
  if (side == Side::before) return;
  restart();
  record_step();
}

template <class S>
void GroupStepper<S>::update_masses() {
  motion_.reset();
  started_ = false;
}

/// Nothing before the present moment continues smoothly.
template <class S>
void GroupStepper<S>::restart() {
  history_count_ = recorded_ = 0;
  started_ = false;
}

template <class S>
void GroupStepper<S>::synchronise_stepper() {
  if (is_stepper_behind_) stepper_.synchronise(true);
  is_stepper_behind_ = started_ = false;
}

/// The stepper's present moment into the group that it is making.
template <class S>
void GroupStepper<S>::record_step() {
  if (!can_use_groups_ || !on_time_) return;
  GroupCoordinates& made = groups_[0];
  for (int c = 0; c < tree_.columns; ++c) {
    const int at = c * group_size + recorded_;
    made.y[at] = stepper_.y()[c], made.dy[at] = stepper_.dy()[c], made.ddy[at] = stepper_.ddy()[c];
  }
  if (++recorded_ < group_size) return;
  std::rotate(groups_.begin(), groups_.end() - 1, groups_.end());
  history_count_ = std::min(history_count_ + 1, 3);
  recorded_ = 0;
}

template <class S>
bool GroupStepper<S>::try_group() {
  if (!can_use_groups_ || history_count_ == 0 || recorded_ > 0 || step_ + group_size - 1 > times_.steps) return false;
  const std::vector<double>& jumps = plan_.prescribed_motion->jump_times();
  const auto jump = std::upper_bound(jumps.begin(), jumps.end(), time() + 1e-9 * times_.duration);
  if (jump != jumps.end() && *jump <= times_.time_of(step_ + group_size - 1) + 1e-9 * times_.duration) return false;
  if (skipped_ > 0) {
    --skipped_;
    return false;
  }
  if (solve_group()) {
    backoff_ = 0;
    return true;
  }
  skipped_ = backoff_ = std::min(2 * backoff_ + 1, max_backoff);
  started_ = false;
  return false;
}

template <class S>
bool GroupStepper<S>::solve_group() {
  if (!sample_drive(time())) return false;
  if (!motion_) {
    motion_ = make_motion(set_, GroupSetup<S>{mechanism_, tree_, plan_.drive, observer_.actuation(), about_,
                                              stepper_.residual_tolerance(), stepper_.matrix_columns(), direct_});
    started_ = false;
  }
  if (!started_) {
    if (is_stepper_behind_) stepper_.synchronise(true), is_stepper_behind_ = false;
    motion_->start(stepper_.equations(), observer_.actuation(), stepper_.y(), stepper_.dy());
  }
  job_.step = times_.duration / static_cast<double>(times_.steps);
  job_.history_count = history_count_;
  for (int k = 0; k < history_count_; ++k)
    job_.history[static_cast<std::size_t>(k)] = &groups_[static_cast<std::size_t>(k) + 1];
  if (!motion_->solve(job_) || !is_accepted()) return false;
  started_ = true;
  return true;
}

/// @param before time of the present moment
/// @return false if the drive asks for shorter steps
template <class S>
bool GroupStepper<S>::sample_drive(double before) {
  const auto spread = [](const auto& from, int l, std::vector<double>& to) {
    for (Eigen::Index k = 0; k < from.size(); ++k) to[static_cast<std::size_t>(k * group_size + l)] = from.data()[k];
  };
  for (int l = 0; l < group_size; ++l) {
    const double time = times_.time_of(step_ + l);
    if (!direct_ && time - before > (1 + 1e-6) * plan_.prescribed_motion->max_step(before)) return false;
    plan_.prescribed_motion->at(time, Side::after, drive_);
    spread(drive_.value, l, job_.value);
    spread(drive_.rate, l, job_.rate);
    spread(drive_.acceleration, l, job_.acceleration);
    if (!plan_.drive.rotation.empty()) {
      spread(drive_.rotation, l, job_.rotation);
      spread(drive_.angular_velocity, l, job_.angular_velocity);
      spread(drive_.angular_acceleration, l, job_.angular_acceleration);
    }
    ends_[static_cast<std::size_t>(l)] = before = time;
  }
  return true;
}

/// As MotionStepper::check_step, and no spherical joint's coordinates ask for another reference.
template <class S>
bool GroupStepper<S>::is_accepted() const {
  if (direct_) return true;
  for (std::size_t l = 0; l < group_size; ++l) {
    const double pivot = std::min(job_.pivot[l], job_.hold_pivot[l]);
    if (!(pivot >= min_group_pivot && job_.distance[l] * job_.distance[l] <= max_matrix_curvature * pivot))
      return false;
    for (const NodeId spherical : tree_.spherical_joints) {
      const auto column = static_cast<std::size_t>(tree_.nodes[static_cast<std::size_t>(spherical) + 1].column);
      const double middle = std::remainder(job_.coordinates.y[column * group_size + l], 2 * std::numbers::pi);
      if (!(std::abs(middle) < max_middle_angle)) return false;
    }
  }
  return true;
}

/// To the next moment of the group found.
template <class S>
void GroupStepper<S>::adopt_next() {
  const auto l = static_cast<std::size_t>(next_in_group_);
  for (int c = 0; c < tree_.columns; ++c) {
    const std::size_t at = static_cast<std::size_t>(c) * group_size + l;
    moment_.y[c] = job_.coordinates.y[at], moment_.dy[c] = job_.coordinates.dy[at],
    moment_.ddy[c] = job_.coordinates.ddy[at];
  }
  moment_.time = ends_[l];
  stepper_.adopt_step(moment_, {.pivot = job_.pivot[l],
                                .actuation_pivot = job_.hold_pivot[l],
                                .distance = job_.distance[l],
                                .iterations = static_cast<int>(job_.iterations[l])});
  is_stepper_behind_ = true;
  ++found_;
  ++step_;
  if (++next_in_group_ < group_size) return;
  std::swap(groups_[0], job_.coordinates);
  std::rotate(groups_.begin(), groups_.end() - 1, groups_.end());
  history_count_ = std::min(history_count_ + 1, 3);
}

template <class S>
bool GroupStepper<S>::observe() {
  if (in_group_) {
    seen_ = &job_.samples[static_cast<std::size_t>(next_in_group_ - 1)];
    seen_->time = time();
    observer_.complete_sample(stepper_.y(), stepper_.dy(), stepper_.ddy(), *seen_);
  } else {
    const bool held = observer_.evaluate(stepper_, Detail::all);
    seen_ = &observer_.sample();
    if (!held) return false;
    seen_->mobility = stepper_.mobility();
  }
  seen_->newton_iterations = stepper_.iterations();
  return true;
}

template <class S>
TreeMotion<S> GroupStepper<S>::at_current_sample() {
  if (in_group_) {
    stepper_.synchronise(false);
    observer_.evaluate(stepper_, Detail::all);
  }
  return {stepper_.state(), stepper_.y(), stepper_.dy(), stepper_.ddy(), stepper_.time(), stepper_.is_explicit()};
}

template class GroupStepper<Planar>;
template class GroupStepper<Spatial>;

}  // namespace balance
