#pragma once
/// One motion as often as it is wanted, place by place in the order of time. Private to cost.

#include "balance/dynamics/observer.hpp"
#include "balance/kinematics/tree_loads.hpp"
#include "balance/motion/configuration_text.hpp"
#include "balance/motion/walk.hpp"
#include "balance/motion/wording.hpp"

namespace balance {

template <class S>
class Rerun {
 public:
  /// @param tree as compiled; the run works on a copy
  /// @param plan done
  Rerun(const Mechanism& mechanism, const Trajectory& trajectory, const Tree<S>& tree, const Plan<S>& plan)
      : mechanism_(mechanism),
        trajectory_(trajectory),
        plan_(plan),
        tree_(tree),
        observer_(mechanism, tree_, plan.freedoms, to_vector<S>(trajectory.about)),
        stepper_(mechanism, tree_, plan),
        loads_(mechanism, tree, plan.schedule->duration()) {
    stepper_.watch(observer_.guard());
  }
  Rerun(const Rerun&) = delete;
  Rerun& operator=(const Rerun&) = delete;

  const Tree<S>& tree() const { return tree_; }
  /// What is there at the place that was seen last.
  const TreeLoads<S>& loads() const { return loads_; }

  /// Calls see(stepper) once for every place of the walk and every side of a jump that no other place holds: the places that
  /// averages are taken over. The stepper's state is that of the place.
  template <class See>
  MotionOutcome run(Detail detail, See&& see) {
    const Actuation<S>& actuation = observer_.actuation();
    if (!actuation.mismatch().empty()) return {MotionStatus::mismatch, 0, actuation.mismatch(), {}};
    bool holds = true;
    loads_.give(0, tree_);
    const bool done = walk(stepper_, *plan_.schedule, trajectory_.samples, [&](const Stop& stop) {
      if (stop.kind == Stop::Kind::after_jump) loads_.give(stepper_.time(), tree_);
      if (stop.kind == Stop::Kind::after_jump && stop.followed) return true;
      holds = observer_.observe(stepper_, detail);
      if (holds) see(stepper_);
      return holds;
    });
    if (!holds) return no_longer_held(stepper_.time(), configuration_text(mechanism_, tree_, stepper_.y()));
    if (!done) return stepper_.outcome();
    return {MotionStatus::done, plan_.schedule->duration(), "", actuation.notes()};
  }

 private:
  const Mechanism& mechanism_;
  const Trajectory& trajectory_;
  const Plan<S>& plan_;
  Tree<S> tree_;
  Observer<S> observer_;
  Stepper<S> stepper_;
  TreeLoads<S> loads_;
};

}  // namespace balance
