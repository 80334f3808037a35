#pragma once
/// A mechanism's tree moving along a compiled trajectory, with everything that follows it.

#include "balance/mechanics/dynamics/sample_evaluator.hpp"
#include "balance/mechanics/kinematics/compiled_trajectory.hpp"
#include "balance/mechanics/kinematics/tree_payloads.hpp"
#include "balance/mechanics/trajectory/motion_source.hpp"

#include <optional>

namespace balance::dynamics {

template <class S>
class TreeMotionSource final : public trajectory::MotionSource {
 public:
  /// @param mechanism, motion must outlive the source, which moves a copy of the tree
  /// @param about world point about which moments are taken
  /// @param detail what evaluate() computes; kinematics: nothing depends on the actuators, else they must hold the
  ///        mechanism throughout the motion
  TreeMotionSource(const Mechanism& mechanism, const kinematics::CompiledMotion<S>& motion, const Vector3& about,
                   Detail detail);

  const MotionOutcome& outcome() const override { return outcome_; }
  const trajectory::PrescribedMotion& prescribed_motion() const override { return *plan_.prescribed_motion; }
  bool begin() override { return stepper_ && check(stepper_->begin()); }
  bool advance(double time) override { return check(stepper_->advance(time)); }
  void update_accelerations(trajectory::Side side) override { stepper_->update_accelerations(side); }
  bool update_payloads() override;
  double time() const override { return stepper_->time(); }
  bool evaluate() override { return evaluator_->evaluate(*stepper_, detail_) || stop_at_actuation_singularity(); }
  const Sample& sample() const override { return evaluator_->sample(); }
  double point_speed(BodyId body, const Vector3& point) const override;
  double angular_speed(BodyId body) const override;

  const Mechanism& mechanism() const { return mechanism_; }
  const kinematics::CompiledTrajectory<S>& plan() const { return plan_; }
  const typename S::Vector& about() const { return about_; }
  Detail detail() const { return detail_; }
  /// As it moves: with the present payloads and references of spherical joints.
  const kinematics::Tree<S>& tree() const { return tree_; }
  // @pre the plan's outcome is done
  const kinematics::TreePayloads<S>& payloads() const { return *payloads_; }
  SampleEvaluator<S>& evaluator() { return *evaluator_; }
  // @pre outcome() was done at first
  kinematics::MotionStepper<S>& stepper() { return *stepper_; }
  /// Sets outcome(), for callers that find the singularity themselves. @return false
  bool stop_at_actuation_singularity();
  /// done, with notes on efforts and reactions.
  MotionOutcome completed_outcome() const;

 private:
  bool check(bool is_reached) {
    if (!is_reached) outcome_ = stepper_->outcome();
    return is_reached;
  }
  const kinematics::NodeState<S>& state_of(const kinematics::FixedFrame<S>& body) const;

  const Mechanism& mechanism_;
  const kinematics::CompiledTrajectory<S>& plan_;
  const typename S::Vector about_;
  const Detail detail_;
  kinematics::Tree<S> tree_;
  std::optional<SampleEvaluator<S>> evaluator_;
  std::optional<kinematics::TreePayloads<S>> payloads_;
  std::optional<kinematics::MotionStepper<S>> stepper_;
  MotionOutcome outcome_;
};

extern template class TreeMotionSource<kinematics::Planar>;
extern template class TreeMotionSource<kinematics::Spatial>;

}  // namespace balance::dynamics
