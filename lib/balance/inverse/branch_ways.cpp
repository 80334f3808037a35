// How a branch is found, and how it is followed where states are far from each other.

#include "balance/inverse/branch.hpp"
#include "balance/motion/missing_start.hpp"
#include "balance/motion/stepper.hpp"

#include <algorithm>
#include <cmath>

namespace balance {

namespace {

constexpr double shortest_part = 1.0 / 4096;  // of the way to the next state
constexpr double longest_way = 1000;          // that is followed, in radians or characteristic lengths

/// A stepper's words without the time, which has no meaning between two states.
std::string timeless(const MotionOutcome& outcome) {
  const std::string::size_type end = outcome.reason.find("s: ");
  return outcome.reason.rfind("at t = ", 0) == 0 && end != std::string::npos ? outcome.reason.substr(end + 3)
                                                                             : outcome.reason;
}

}  // namespace

/// In as many steps as it takes.
template <class S>
bool Branch<S>::walk(const double* q) {
  const std::vector<double> from = q_;
  std::vector<double> next(q_.size());
  double done = 0, size = 0.5;
  while (done < 1) {
    const double part = std::min(1.0, done + size);
    for (std::size_t k = 0; k < next.size(); ++k) next[k] = part == 1 ? q[k] : (1 - part) * from[k] + part * q[k];
    if (step(next.data())) {
      done = part;
      size = std::min(2 * size, 0.5);
    } else if ((size /= 2) < shortest_part) {
      return false;
    }
  }
  return true;
}

template <class S>
Plan<S> Branch<S>::plan_to(const double* q) const {
  Plan<S> plan;
  plan.outcome.status = MotionStatus::done;
  plan.drive = drive_;
  plan.start = y_;
  plan.freedoms = freedoms_;
  plan.redundant = redundant_;
  Schedule::Request request;
  request.law.kind = LawKind::cubic;
  request.from.value = Eigen::Map<const VectorX>(q_.data(), freedoms_);
  request.to.value = Eigen::Map<const VectorX>(q, freedoms_);
  plan.schedule.emplace(request);
  return plan;
}

/// The stepper's way, which comes nearer to singular configurations and knows what they are called.
template <class S>
MotionOutcome Branch<S>::lead(const double* q, const char* words) {
  MotionOutcome outcome;
  outcome.status = MotionStatus::done;
  if (freedoms_ == 0) {  // nowhere to go
    outcome.status = settle() ? MotionStatus::done : MotionStatus::constraint_singularity;
    outcome.reason = fresh_ ? "" : "constraint singularity: the loop closures lose rank";
    return outcome;
  }
  const Plan<S> plan = plan_to(q);
  Stepper<S> stepper(mechanism_, tree_, plan);
  const bool there = stepper.begin() && stepper.advance(plan.schedule->duration());
  if (there) {
    y_ = Eigen::Map<const VectorX>(stepper.y(), tree_.columns);
    std::copy_n(q, freedoms_, q_.begin());
    if (settle()) return outcome;
  }
  outcome.status = there ? MotionStatus::drive_singularity : stepper.outcome().status;
  outcome.reason = there ? "drive singularity: the independent coordinates no longer determine the motion"
                         : timeless(stepper.outcome());
  outcome.reason.insert(0, words);
  return outcome;
}

template <class S>
typename Branch<S>::Mark Branch<S>::mark() const {
  Mark mark{y_, q_, {}};
  for (const NodeId spherical : tree_.spherical_joints) mark.references.push_back(tree_.nodes[spherical].R_PF);
  return mark;
}

template <class S>
void Branch<S>::go_back(const Mark& mark) {
  y_ = mark.y;
  q_ = mark.q;
  for (std::size_t b = 0; b < tree_.spherical_joints.size(); ++b)
    tree_.nodes[tree_.spherical_joints[b]].R_PF = mark.references[b];
  fresh_ = false;
}

template <class S>
MotionOutcome Branch<S>::go_round(const double* q) {
  MotionOutcome outcome;
  outcome.status = MotionStatus::done;
  if (!assembled_) return assemble(q, {});
  if (fresh_ && std::equal(q_.begin(), q_.end(), q)) return outcome;
  if (step(q)) return outcome;
  for (int k = 0; k < freedoms_; ++k) {
    const double unit = drive_.linear[static_cast<std::size_t>(k)].is_length ? tree_.length : 1;
    if (std::abs(q[k] - q_[static_cast<std::size_t>(k)]) <= longest_way * unit) continue;
    outcome.status = MotionStatus::unreachable;
    outcome.reason = mechanism_.coordinates[independent_[static_cast<std::size_t>(k)]].name +
                     " is too far from the state before to be followed there";
    return outcome;
  }
  const Mark before = mark();
  if (walk(q)) return outcome;
  fresh_ = false;
  outcome = lead(q, "on the straight way from the state before: ");
  if (outcome.status != MotionStatus::done) go_back(before);
  return outcome;
}

template <class S>
MotionOutcome Branch<S>::assemble(const double* q, const std::vector<CoordinateValue>& near) {
  if (direct_) return go(q);
  const Mark before = mark();
  for (std::size_t b = 0; b < tree_.spherical_joints.size(); ++b)
    tree_.nodes[tree_.spherical_joints[b]].R_PF = first_references_[b];
  Mechanism rough = mechanism_;
  const auto put = [&](const CoordinateValue& value, bool always) {
    const auto same = [&](const CoordinateValue& other) { return other.coordinate == value.coordinate; };
    const bool named = std::erase_if(rough.assembly, same) > 0;
    if (named || always) rough.assembly.push_back(value);
  };
  for (const CoordinateValue& value : near) put(value, true);
  for (int k = 0; k < freedoms_; ++k) put({independent_[static_cast<std::size_t>(k)], q[k]}, false);
  System<S> system(tree_, drive_);
  DriveSample target;
  target.value = Eigen::Map<const VectorX>(q, freedoms_);
  const Solution found = find_pose(rough, tree_, system, target);
  MotionOutcome outcome;
  if (found.found) {
    y_ = found.y;
    std::copy_n(q, freedoms_, q_.begin());
    outcome = lead(q, "");
    assembled_ = assembled_ || outcome.status == MotionStatus::done;
  } else {
    PoseTarget pose;
    for (int k = 0; k < freedoms_; ++k) pose.joints.push_back({independent_[static_cast<std::size_t>(k)], q[k]});
    outcome = explain_missing_start(rough, tree_, found, pose);
    if (outcome.status == MotionStatus::unreachable)
      outcome.reason = "the loops cannot be closed with these independent coordinates: " +
                       outcome.reason.substr(std::min(outcome.reason.size(), outcome.reason.find(": ") + 2));
  }
  if (outcome.status != MotionStatus::done) go_back(before);
  return outcome;
}

#define BALANCE_INSTANTIATE(S)                                        \
  template bool Branch<S>::walk(const double*);                       \
  template Plan<S> Branch<S>::plan_to(const double*) const;           \
  template MotionOutcome Branch<S>::lead(const double*, const char*); \
  template Branch<S>::Mark Branch<S>::mark() const;                   \
  template void Branch<S>::go_back(const Branch<S>::Mark&);           \
  template MotionOutcome Branch<S>::go_round(const double*);          \
  template MotionOutcome Branch<S>::assemble(const double*, const std::vector<CoordinateValue>&);
BALANCE_INSTANTIATE(Planar)
BALANCE_INSTANTIATE(Spatial)
#undef BALANCE_INSTANTIATE

}  // namespace balance
