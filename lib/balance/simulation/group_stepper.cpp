#include "balance/simulation/group_stepper.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace balance {

namespace {

/// Smaller pivots are the stepper's: it then looks at how near to a singularity the motion comes.
constexpr double sure_pivot = 8 * near_singular;
constexpr double sure_middle = 0.99;  // of a spherical joint's angles [rad]; the stepper counts them anew from 1 on
constexpr int longest_pause = 63;

std::unique_ptr<GroupMotion<Planar>> make_motion(InstructionSet set, const GroupSetup<Planar>& setup) {
  return lane_kernels(set).planar_motion(setup);
}
std::unique_ptr<GroupMotion<Spatial>> make_motion(InstructionSet set, const GroupSetup<Spatial>& setup) {
  return lane_kernels(set).spatial_motion(setup);
}

}  // namespace

template <class S>
GroupStepper<S>::GroupStepper(const Mechanism& mechanism, const Tree<S>& tree, const Plan<S>& plan,
                              const WalkTimes& times, const typename S::Vector& about, Stepper<S>& stepper,
                              Observer<S>& observer, InstructionSet set)
    : mechanism_(mechanism),
      tree_(tree),
      plan_(plan),
      times_(times),
      about_(about),
      stepper_(stepper),
      observer_(observer),
      set_(set),
      direct_(stepper.direct()),
      possible_(!plan.redundant && tree.place_rows == tree.closure_rows &&
                !stepper.equations().structurally_singular() && tree.columns > 0 && tree.columns <= most_dense &&
                observer.is_plain()) {
  groups_.fill(GroupMoments(tree.columns));
  job_.moments = GroupMoments(tree.columns);
  for (auto* numbers : {&job_.value, &job_.rate, &job_.acceleration})
    numbers->resize(static_cast<std::size_t>(plan.drive.values()) * group_size);
  job_.rotation.resize(std::size_t{9} * group_size);
  for (auto* numbers : {&job_.angular_velocity, &job_.angular_acceleration})
    numbers->resize(std::size_t{3} * group_size);
  job_.samples.fill(observer.last());
  for (VectorX* values : {&moment_.y, &moment_.dy, &moment_.ddy}) values->setZero(tree.columns);
}

template <class S>
bool GroupStepper<S>::begin() {
  if (!stepper_.begin()) return false;
  restart();
  step_ = 1;
  on_time_ = true;
  note();
  return true;
}

template <class S>
bool GroupStepper<S>::advance(double time) {
  on_time_ = step_ <= times_.steps && time == times_.of(step_);
  if (at_ == group_size && on_time_ && try_group()) at_ = 0;
  in_group_ = at_ < group_size;
  if (in_group_) {
    follow();
    return true;
  }
  catch_up();
  const int references = stepper_.references();
  if (!stepper_.advance(time)) return false;
  if (stepper_.references() != references) {  // coordinates before are not comparable, nor is the tree
    restart();
    motion_.reset();
  }
  note();
  if (on_time_) ++step_;
  return true;
}

template <class S>
void GroupStepper<S>::accelerate(Side side) {
  catch_up();
  in_group_ = false;
  stepper_.accelerate(side);
  if (side == Side::before) return;
  restart();
  note();
}

template <class S>
void GroupStepper<S>::reload() {
  motion_.reset();
  started_ = false;
}

/// Nothing before the present moment continues smoothly.
template <class S>
void GroupStepper<S>::restart() {
  known_ = made_ = 0;
  started_ = false;
}

template <class S>
void GroupStepper<S>::catch_up() {
  if (behind_) stepper_.catch_up(true);
  behind_ = started_ = false;
}

/// The stepper's present moment into the group that it is making.
template <class S>
void GroupStepper<S>::note() {
  if (!possible_ || !on_time_) return;
  GroupMoments& made = groups_[0];
  for (int c = 0; c < tree_.columns; ++c) {
    const int at = c * group_size + made_;
    made.y[at] = stepper_.y()[c], made.dy[at] = stepper_.dy()[c], made.ddy[at] = stepper_.ddy()[c];
  }
  if (++made_ < group_size) return;
  std::rotate(groups_.begin(), groups_.end() - 1, groups_.end());
  known_ = std::min(known_ + 1, 3);
  made_ = 0;
}

template <class S>
bool GroupStepper<S>::try_group() {
  if (!possible_ || known_ == 0 || made_ > 0 || step_ + group_size - 1 > times_.steps) return false;
  const std::vector<double>& jumps = plan_.schedule->jumps();
  const auto jump = std::upper_bound(jumps.begin(), jumps.end(), time() + 1e-9 * times_.duration);
  if (jump != jumps.end() && *jump <= times_.of(step_ + group_size - 1) + 1e-9 * times_.duration) return false;
  if (rest_ > 0) {
    --rest_;
    return false;
  }
  if (find_group()) {
    pause_ = 0;
    return true;
  }
  rest_ = pause_ = std::min(2 * pause_ + 1, longest_pause);
  started_ = false;
  return false;
}

template <class S>
bool GroupStepper<S>::find_group() {
  if (!sample_drive(time())) return false;
  if (!motion_) {
    motion_ = make_motion(set_, GroupSetup<S>{mechanism_, tree_, plan_.drive, observer_.actuation(), about_,
                                              stepper_.round_off(), stepper_.matrix_columns(), direct_});
    started_ = false;
  }
  if (!started_) {
    if (behind_) stepper_.catch_up(true), behind_ = false;
    motion_->start(stepper_.equations(), observer_.actuation(), stepper_.y(), stepper_.dy());
  }
  job_.step = times_.duration / static_cast<double>(times_.steps);
  job_.known = known_;
  for (int k = 0; k < known_; ++k) job_.before[static_cast<std::size_t>(k)] = &groups_[static_cast<std::size_t>(k) + 1];
  if (!motion_->find(job_) || !is_sure()) return false;
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
    const double time = times_.of(step_ + l);
    if (!direct_ && time - before > (1 + 1e-6) * plan_.schedule->longest_step(before)) return false;
    plan_.schedule->at(time, Side::after, drive_);
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

/// As Stepper::judge, and no spherical joint's coordinates ask for another reference.
template <class S>
bool GroupStepper<S>::is_sure() const {
  if (direct_) return true;
  for (std::size_t l = 0; l < group_size; ++l) {
    const double pivot = std::min(job_.pivot[l], job_.hold_pivot[l]);
    if (!(pivot >= sure_pivot && job_.way[l] * job_.way[l] <= most_curvature * pivot)) return false;
    for (const NodeId spherical : tree_.spherical_joints) {
      const auto column = static_cast<std::size_t>(tree_.nodes[static_cast<std::size_t>(spherical) + 1].column);
      const double middle = std::remainder(job_.moments.y[column * group_size + l], 2 * std::numbers::pi);
      if (!(std::abs(middle) < sure_middle)) return false;
    }
  }
  return true;
}

/// To the next moment of the group found.
template <class S>
void GroupStepper<S>::follow() {
  const auto l = static_cast<std::size_t>(at_);
  for (int c = 0; c < tree_.columns; ++c) {
    const std::size_t at = static_cast<std::size_t>(c) * group_size + l;
    moment_.y[c] = job_.moments.y[at], moment_.dy[c] = job_.moments.dy[at], moment_.ddy[c] = job_.moments.ddy[at];
  }
  moment_.time = ends_[l];
  stepper_.follow(moment_, {.pivot = job_.pivot[l],
                            .hold_pivot = job_.hold_pivot[l],
                            .way = job_.way[l],
                            .iterations = static_cast<int>(job_.iterations[l])});
  behind_ = true;
  ++found_;
  ++step_;
  if (++at_ < group_size) return;
  std::swap(groups_[0], job_.moments);
  std::rotate(groups_.begin(), groups_.end() - 1, groups_.end());
  known_ = std::min(known_ + 1, 3);
}

template <class S>
bool GroupStepper<S>::observe() {
  if (in_group_) {
    seen_ = &job_.samples[static_cast<std::size_t>(at_ - 1)];
    seen_->time = time();
    observer_.complete(stepper_.y(), stepper_.dy(), stepper_.ddy(), *seen_);
  } else {
    const bool held = observer_.observe(stepper_, Detail::everything);
    seen_ = &observer_.last();
    if (!held) return false;
    seen_->mobility = stepper_.mobility();
  }
  seen_->newton_iterations = stepper_.iterations();
  return true;
}

template <class S>
Instant<S> GroupStepper<S>::closely() {
  if (in_group_) {
    stepper_.catch_up(false);
    observer_.observe(stepper_, Detail::everything);
  }
  return {stepper_.state(), stepper_.y(), stepper_.dy(), stepper_.ddy(), stepper_.time(), stepper_.direct()};
}

template class GroupStepper<Planar>;
template class GroupStepper<Spatial>;

}  // namespace balance
