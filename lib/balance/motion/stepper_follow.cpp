// Steps to moments that were found elsewhere.

#include "balance/motion/stepper.hpp"

#include <algorithm>

namespace balance {

template <class S>
void MotionStepper<S>::adopt_step(const CoordinateSample& next, const StepReport& measures) {
  std::swap(second_previous_, previous_);
  std::swap(previous_, now_);
  now_ = next;
  history_count_ = std::min(history_count_ + 1, 2);
  iterations_ = measures.iterations;
  if (direct_) return;
  way_ = measures.distance;
  hold_pivot_ = measures.actuation_pivot;
  if (guard_ != nullptr) actuation_extrapolation_.add_sample(hold_pivot_, next.time);
  approach_.add_sample(measures.pivot, next.time);
  singularity_monitor_.sample(equations_, measures.pivot, hold_pivot_, way_);
}

template <class S>
void MotionStepper<S>::synchronise(bool keep) {
  plan_.prescribed_motion->at(now_.time, Side::after, sample_);
  if (direct_) return;
  compute_poses(tree_, now_.y.data(), state_);
  equations_.evaluate(state_, now_.y.data(), sample_, x_.data());
  compute_angular_velocities(tree_, now_.dy.data(), state_);
  if (tree_.has_sliding_closures) compute_origin_velocities(tree_, now_.dy.data(), state_);
  if (!keep) return;
  equations_.factorise(pivot_threshold_);
  store_matrices();
}

#define BALANCE_INSTANTIATE(S)                                                                 \
  template void MotionStepper<S>::adopt_step(const CoordinateSample& next, const StepReport&); \
  template void MotionStepper<S>::synchronise(bool);
BALANCE_INSTANTIATE(Planar)
BALANCE_INSTANTIATE(Spatial)
#undef BALANCE_INSTANTIATE

}  // namespace balance
