#pragma once
/// A GroupSolver in lanes: as many moments at once as the instruction set has lanes, one such part of a group after another.
/// Private to lanes.

#include "balance/lanes/least_singular.hpp"
#include "balance/lanes/moment.hpp"
#include "balance/lanes/step.hpp"

namespace balance {

/// @tparam L the space S over packs
template <class L, class S>
class LaneGroupSolver final : public GroupSolver<S> {
 public:
  explicit LaneGroupSolver(const GroupSetup<S>& setup)
      : setup_(setup), step_(setup_), least_singular_(step_.equations()), moment_(setup_) {}

  void start(const KinematicEquations<S>& equations, const Actuation<S>& actuation, const double* y,
             const double* dy) override {
    step_.start(equations, actuation, y, dy);
  }

  bool solve(GroupJob& job) override {
    using T = typename L::Scalar;
    for (int first = 0; first < group_size; first += T::lanes) {
      if (!step_.find(job, first)) return false;
      moment_.evaluate(step_.equations(), step_.actuation(), step_.state(), step_.dy(), step_.ddy());
      moment_.store(setup_.direct ? T(1.0) : least_singular_.compute(step_.equations()), first, job.samples);
    }
    return true;
  }

 private:
  GroupSetup<S> setup_;
  LaneStepper<L, S> step_;
  LaneMinSingularValue<L> least_singular_;
  LaneSampleEvaluator<L, S> moment_;
};

}  // namespace balance
