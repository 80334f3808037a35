#pragma once
/// One motion as often as it is wanted, place by place in the order of time. Private to cost.

#include "balance/dynamics/observer.hpp"
#include "balance/kinematics/tree_loads.hpp"
#include "balance/motion/configuration_text.hpp"
#include "balance/motion/walk.hpp"
#include "balance/motion/wording.hpp"

namespace balance {

template <class S>
class MotionReplay {
 public:
  /// @param tree as compiled; the run works on a copy
  /// @param plan done
  MotionReplay(const Mechanism& mechanism, const Trajectory& trajectory, const Tree<S>& tree,
               const CompiledTrajectory<S>& plan)
      : mechanism_(mechanism),
        trajectory_(trajectory),
        plan_(plan),
        tree_(tree),
        observer_(mechanism, tree_, plan.freedoms, to_vector<S>(trajectory.about)),
        stepper_(mechanism, tree_, plan),
        loads_(mechanism, tree, plan.prescribed_motion->duration()) {
    stepper_.set_regularity_monitor(observer_.regularity_monitor());
  }
  MotionReplay(const MotionReplay&) = delete;
  MotionReplay& operator=(const MotionReplay&) = delete;

  const Tree<S>& tree() const { return tree_; }
  /// What is there at the place that was seen last.
  const TreePayloads<S>& loads() const { return loads_; }

  /// Calls see(stepper) once for every place of the walk and every side of a jump that no other place holds: the places that
  /// averages are taken over. The stepper's state is that of the place.
  template <class See>
  MotionOutcome run(Detail detail, See&& see) {
    const Actuation<S>& actuation = observer_.actuation();
    if (!actuation.mismatch().empty()) return {MotionStatus::mismatch, 0, actuation.mismatch(), {}};
    bool holds = true;
    loads_.apply(0, tree_);
    const bool done =
        visit_time_grid(stepper_, *plan_.prescribed_motion, trajectory_.samples, [&](const TimeGridPoint& stop) {
          if (stop.kind == TimeGridPoint::Kind::after_jump) loads_.apply(stepper_.time(), tree_);
          if (stop.kind == TimeGridPoint::Kind::after_jump && stop.has_coincident_next) return true;
          holds = observer_.evaluate(stepper_, detail);
          if (holds) see(stepper_);
          return holds;
        });
    if (!holds)
      return make_actuation_singularity_outcome(stepper_.time(), format_configuration(mechanism_, tree_, stepper_.y()));
    if (!done) return stepper_.outcome();
    return {MotionStatus::done, plan_.prescribed_motion->duration(), "", actuation.notes()};
  }

 private:
  const Mechanism& mechanism_;
  const Trajectory& trajectory_;
  const CompiledTrajectory<S>& plan_;
  Tree<S> tree_;
  SampleEvaluator<S> observer_;
  MotionStepper<S> stepper_;
  TreePayloads<S> loads_;
};

}  // namespace balance
