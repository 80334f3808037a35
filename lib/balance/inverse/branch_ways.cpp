// How a branch is found, and how it is followed where states are far from each other.

#include "balance/inverse/branch.hpp"
#include "balance/motion/missing_start.hpp"
#include "balance/motion/stepper.hpp"

#include <algorithm>
#include <cmath>

namespace balance {

namespace {

constexpr double min_path_fraction = 1.0 / 4096;  // of the way to the next state
constexpr double max_tracking_distance = 1000;    // that is followed, in radians or characteristic lengths

/// A stepper's words without the time, which has no meaning between two states.
std::string strip_time_prefix(const MotionOutcome& outcome) {
  const std::string::size_type end = outcome.reason.find("s: ");
  return outcome.reason.rfind("at t = ", 0) == 0 && end != std::string::npos ? outcome.reason.substr(end + 3)
                                                                             : outcome.reason;
}

}  // namespace

/// In as many steps as it takes.
template <class S>
bool AssemblyBranch<S>::step_repeatedly(const double* q) {
  const std::vector<double> from = q_;
  std::vector<double> next(q_.size());
  double done = 0, size = 0.5;
  while (done < 1) {
    const double part = std::min(1.0, done + size);
    for (std::size_t k = 0; k < next.size(); ++k) next[k] = part == 1 ? q[k] : (1 - part) * from[k] + part * q[k];
    if (step(next.data())) {
      done = part;
      size = std::min(2 * size, 0.5);
    } else if ((size /= 2) < min_path_fraction) {
      return false;
    }
  }
  return true;
}

template <class S>
CompiledTrajectory<S> AssemblyBranch<S>::compile_path_to(const double* q) const {
  CompiledTrajectory<S> plan;
  plan.outcome.status = MotionStatus::done;
  plan.drive = drive_;
  plan.start = y_;
  plan.freedoms = freedoms_;
  plan.has_redundant_closures = redundant_;
  PrescribedMotion::Request request;
  request.law.kind = MotionLawKind::cubic;
  request.from.value = Eigen::Map<const VectorX>(q_.data(), freedoms_);
  request.to.value = Eigen::Map<const VectorX>(q, freedoms_);
  plan.prescribed_motion.emplace(request);
  return plan;
}

/// The stepper's way, which comes nearer to singular configurations and knows what they are called.
template <class S>
MotionOutcome AssemblyBranch<S>::track_with_stepper(const double* q, const char* words) {
  MotionOutcome outcome;
  outcome.status = MotionStatus::done;
  if (freedoms_ == 0) {  // nowhere to go
    outcome.status = update_equations() ? MotionStatus::done : MotionStatus::constraint_singularity;
    outcome.reason = has_current_equations_ ? "" : "constraint singularity: the loop closures lose rank";
    return outcome;
  }
  const CompiledTrajectory<S> plan = compile_path_to(q);
  MotionStepper<S> stepper(mechanism_, tree_, plan);
  const bool there = stepper.begin() && stepper.advance(plan.prescribed_motion->duration());
  if (there) {
    y_ = Eigen::Map<const VectorX>(stepper.y(), tree_.columns);
    std::copy_n(q, freedoms_, q_.begin());
    if (update_equations()) return outcome;
  }
  outcome.status = there ? MotionStatus::drive_singularity : stepper.outcome().status;
  outcome.reason = there ? "drive singularity: the independent coordinates no longer determine the motion"
                         : strip_time_prefix(stepper.outcome());
  outcome.reason.insert(0, words);
  return outcome;
}

template <class S>
typename AssemblyBranch<S>::Snapshot AssemblyBranch<S>::snapshot() const {
  Snapshot mark{y_, q_, {}};
  for (const NodeId spherical : tree_.spherical_joints) mark.references.push_back(tree_.nodes[spherical].R_PF);
  return mark;
}

template <class S>
void AssemblyBranch<S>::restore(const Snapshot& mark) {
  y_ = mark.y;
  q_ = mark.q;
  for (std::size_t b = 0; b < tree_.spherical_joints.size(); ++b)
    tree_.nodes[tree_.spherical_joints[b]].R_PF = mark.references[b];
  has_current_equations_ = false;
}

template <class S>
MotionOutcome AssemblyBranch<S>::move_closed_to(const double* q) {
  MotionOutcome outcome;
  outcome.status = MotionStatus::done;
  if (!assembled_) return assemble(q, {});
  if (has_current_equations_ && std::equal(q_.begin(), q_.end(), q)) return outcome;
  if (step(q)) return outcome;
  for (int k = 0; k < freedoms_; ++k) {
    const double unit = drive_.linear[static_cast<std::size_t>(k)].is_length ? tree_.characteristic_length : 1;
    if (std::abs(q[k] - q_[static_cast<std::size_t>(k)]) <= max_tracking_distance * unit) continue;
    outcome.status = MotionStatus::unreachable;
    outcome.reason = mechanism_.coordinates[independent_[static_cast<std::size_t>(k)]].name +
                     " is too far from the state before to be followed there";
    return outcome;
  }
  const Snapshot before = snapshot();
  if (step_repeatedly(q)) return outcome;
  has_current_equations_ = false;
  outcome = track_with_stepper(q, "on the straight way from the state before: ");
  if (outcome.status != MotionStatus::done) restore(before);
  return outcome;
}

template <class S>
MotionOutcome AssemblyBranch<S>::assemble(const double* q, const std::vector<CoordinateValue>& near) {
  if (direct_) return move_to(q);
  const Snapshot before = snapshot();
  for (std::size_t b = 0; b < tree_.spherical_joints.size(); ++b)
    tree_.nodes[tree_.spherical_joints[b]].R_PF = initial_references_[b];
  Mechanism rough = mechanism_;
  const auto put = [&](const CoordinateValue& value, bool always) {
    const auto same = [&](const CoordinateValue& other) { return other.coordinate == value.coordinate; };
    const bool named = std::erase_if(rough.assembly, same) > 0;
    if (named || always) rough.assembly.push_back(value);
  };
  for (const CoordinateValue& value : near) put(value, true);
  for (int k = 0; k < freedoms_; ++k) put({independent_[static_cast<std::size_t>(k)], q[k]}, false);
  ConstraintSystem<S> system(tree_, drive_);
  DriveSample target;
  target.value = Eigen::Map<const VectorX>(q, freedoms_);
  const AssemblySolution found = solve_pose(rough, tree_, system, target);
  MotionOutcome outcome;
  if (found.found) {
    y_ = found.y;
    std::copy_n(q, freedoms_, q_.begin());
    outcome = track_with_stepper(q, "");
    assembled_ = assembled_ || outcome.status == MotionStatus::done;
  } else {
    PoseTarget pose;
    for (int k = 0; k < freedoms_; ++k) pose.joints.push_back({independent_[static_cast<std::size_t>(k)], q[k]});
    outcome = explain_assembly_failure(rough, tree_, found, pose);
    if (outcome.status == MotionStatus::unreachable)
      outcome.reason = "the loops cannot be closed with these independent coordinates: " +
                       outcome.reason.substr(std::min(outcome.reason.size(), outcome.reason.find(": ") + 2));
  }
  if (outcome.status != MotionStatus::done) restore(before);
  return outcome;
}

#define BALANCE_INSTANTIATE(S)                                                              \
  template bool AssemblyBranch<S>::step_repeatedly(const double*);                          \
  template CompiledTrajectory<S> AssemblyBranch<S>::compile_path_to(const double*) const;   \
  template MotionOutcome AssemblyBranch<S>::track_with_stepper(const double*, const char*); \
  template AssemblyBranch<S>::Snapshot AssemblyBranch<S>::mark() const;                     \
  template void AssemblyBranch<S>::restore(const AssemblyBranch<S>::Snapshot&);             \
  template MotionOutcome AssemblyBranch<S>::move_closed_to(const double*);                  \
  template MotionOutcome AssemblyBranch<S>::assemble(const double*, const std::vector<CoordinateValue>&);
BALANCE_INSTANTIATE(Planar)
BALANCE_INSTANTIATE(Spatial)
#undef BALANCE_INSTANTIATE

}  // namespace balance
