// Steps to moments that were found elsewhere.

#include "balance/motion/stepper.hpp"

#include <algorithm>

namespace balance {

template <class S>
void Stepper<S>::follow(const MotionMoment& next, const StepMeasures& measures) {
  std::swap(older_, before_);
  std::swap(before_, now_);
  now_ = next;
  past_ = std::min(past_ + 1, 2);
  iterations_ = measures.iterations;
  if (direct_) return;
  way_ = measures.way;
  hold_pivot_ = measures.hold_pivot;
  if (guard_ != nullptr) hold_approach_.see(hold_pivot_, next.time);
  approach_.see(measures.pivot, next.time);
  passages_.see(equations_, measures.pivot, hold_pivot_, way_);
}

template <class S>
void Stepper<S>::catch_up(bool keep) {
  plan_.schedule->at(now_.time, Side::after, sample_);
  if (direct_) return;
  poses(tree_, now_.y.data(), state_);
  equations_.fill(state_, now_.y.data(), sample_, x_.data());
  angular_velocities(tree_, now_.dy.data(), state_);
  if (tree_.slides) origin_velocities(tree_, now_.dy.data(), state_);
  if (!keep) return;
  equations_.factorise(floor_);
  settle();
}

#define BALANCE_INSTANTIATE(S)                                                     \
  template void Stepper<S>::follow(const MotionMoment& next, const StepMeasures&); \
  template void Stepper<S>::catch_up(bool);
BALANCE_INSTANTIATE(Planar)
BALANCE_INSTANTIATE(Spatial)
#undef BALANCE_INSTANTIATE

}  // namespace balance
