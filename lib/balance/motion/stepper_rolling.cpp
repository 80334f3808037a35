// The way of a mechanism in which something rolls: rates are prescribed, and places follow from all of the way.

#include "balance/motion/extrapolation.hpp"
#include "balance/motion/stepper.hpp"

namespace balance {

namespace {

constexpr double integration_tolerance = 1e-13;  // of a step, in radians or characteristic lengths

}  // namespace

/// Rates that the closures and the drive determine, at any configuration.
template <class S>
bool MotionStepper<S>::rates_at(double time, const VectorX& y, VectorX& dy) {
  if (--evaluations_left_ < 0) return false;
  DriveSample sample;
  plan_.prescribed_motion->at(time, Side::after, sample);
  compute_poses(tree_, y.data(), state_);
  equations_.evaluate(state_, y.data(), sample, x_.data());
  if (!y.allFinite() || !equations_.factorise(pivot_threshold_)) return false;
  equations_.velocity_rhs(sample, rates_.data());
  equations_.solve(rates_.data());
  std::copy_n(rates_.data(), tree_.columns, dy.data());
  return true;
}

/// What Newton's corrections cannot find: they keep to what rates are possible.
template <class S>
bool MotionStepper<S>::integrate(double time) {
  const VectorX scale = Eigen::Map<const VectorX>(equations_.column_scale().data(), tree_.columns);
  predicted_ = now_.y;
  const auto rates = [this](double at, const VectorX& y, VectorX& dy) { return rates_at(at, y, dy); };
  return step_by_extrapolation(rates, now_.time, time - now_.time, now_.dy, scale, integration_tolerance, predicted_);
}

#define BALANCE_INSTANTIATE(S)                                                \
  template bool MotionStepper<S>::rates_at(double, const VectorX&, VectorX&); \
  template bool MotionStepper<S>::integrate(double);
BALANCE_INSTANTIATE(Planar)
BALANCE_INSTANTIATE(Spatial)
#undef BALANCE_INSTANTIATE

}  // namespace balance
