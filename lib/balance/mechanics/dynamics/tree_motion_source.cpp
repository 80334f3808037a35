#include "balance/mechanics/dynamics/tree_motion_source.hpp"

#include "balance/mechanics/kinematics/assembly.hpp"
#include "balance/mechanics/kinematics/forward_kinematics.hpp"

namespace balance::dynamics {

template <class S>
TreeMotionSource<S>::TreeMotionSource(const Mechanism& mechanism, const kinematics::CompiledMotion<S>& motion,
                                      const Vector3& about, Detail detail)
    : mechanism_(mechanism),
      plan_(motion.plan),
      about_(kinematics::to_vector<S>(about)),
      detail_(detail),
      tree_(motion.tree),
      outcome_(motion.plan.outcome) {
  if (outcome_.status != MotionStatus::done) return;
  evaluator_.emplace(mechanism, tree_, plan_.freedoms, about_);
  payloads_.emplace(mechanism, tree_, plan_.prescribed_motion->duration());
  const bool needs_actuators = detail != Detail::kinematics;
  if (const std::string& mismatch = evaluator_->actuation().mismatch(); needs_actuators && !mismatch.empty()) {
    outcome_ = {MotionStatus::mismatch, 0, mismatch, {}};
    return;
  }
  stepper_.emplace(mechanism, tree_, plan_);
  if (needs_actuators) stepper_->set_regularity_monitor(evaluator_->regularity_monitor());
}

template <class S>
bool TreeMotionSource<S>::update_payloads() {
  return payloads_->apply(time(), tree_);
}

template <class S>
bool TreeMotionSource<S>::stop_at_actuation_singularity() {
  outcome_ =
      trajectory::make_actuation_singularity_outcome(time(), format_configuration(mechanism_, tree_, stepper_->y()));
  return false;
}

template <class S>
const kinematics::NodeState<S>& TreeMotionSource<S>::state_of(const kinematics::FixedFrame<S>& body) const {
  return stepper_->state()[static_cast<std::size_t>(body.node)];
}

template <class S>
double TreeMotionSource<S>::point_speed(BodyId body, const Vector3& point) const {
  const kinematics::FixedFrame<S>& frame = tree_.bodies[static_cast<std::size_t>(body)];
  const typename S::Vector p_N = frame.p_N + frame.R_N * kinematics::to_vector<S>(point);
  return kinematics::point_velocity<S>(state_of(frame), p_N).norm();
}

template <class S>
double TreeMotionSource<S>::angular_speed(BodyId body) const {
  return kinematics::angular_to_3d(state_of(tree_.bodies[static_cast<std::size_t>(body)]).angular_velocity).norm();
}

template <class S>
MotionOutcome TreeMotionSource<S>::completed_outcome() const {
  return {MotionStatus::done, plan_.prescribed_motion->duration(), "", evaluator_->actuation().notes()};
}

template class TreeMotionSource<kinematics::Planar>;
template class TreeMotionSource<kinematics::Spatial>;

}  // namespace balance::dynamics
