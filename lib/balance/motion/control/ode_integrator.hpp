#pragma once
/// Integration of ordinary differential equations step by step, with error control: the interface to Boost.Odeint.

#include "balance/foundation/base/elementary.hpp"

#include <boost/numeric/odeint/stepper/controlled_runge_kutta.hpp>
#include <boost/numeric/odeint/stepper/generation/make_controlled.hpp>
#include <boost/numeric/odeint/stepper/runge_kutta_dopri5.hpp>

#include <algorithm>
#include <vector>

namespace balance::control {

/// Step size control: Odeint's own rule, with powers that are the same on every processor.
class StepSizeController : public boost::numeric::odeint::default_step_adjuster<double, double> {
 public:
  double decrease_step(double step, double error, int order) const {
    return step * std::max(0.9 * elementary::pow(error, -1.0 / (order - 1)), 0.2);
  }
  double increase_step(double step, double error, int order) const {
    if (error >= 0.5) return step;
    return step * (0.9 * elementary::pow(std::max(elementary::pow(5, -order), error), -1.0 / order));
  }
};

/// Dormand–Prince 5(4) (J. Comput. Appl. Math. 6, 1980): the derivative at the end of a step is reused by the next
/// step.
class Integrator {
 public:
  using State = std::vector<double>;

  Integrator(double absolute, double relative) : stepper_(ErrorChecker(absolute, relative), StepSizeController()) {}

  /// Call when the right-hand side has changed: discards the last derivative.
  void restart() { stepper_.reset(); }

  /// @param derivative void(const State& x, State& dxdt, double t); may throw to reject a state: x and time then do not
  ///        change
  /// @param step step size; on return, the size to try next
  /// @return false if the error was too large: x and time then do not change
  template <class Derivative>
  bool try_step(Derivative&& derivative, State& x, double& time, double& step) {
    return stepper_.try_step(derivative, x, time, step) == boost::numeric::odeint::success;
  }

  /// Makes one step from x with this step size, whatever its error; the next try_step() starts anew.
  template <class Derivative>
  void step_without_error_control(Derivative&& derivative, State& x, double time, double step) {
    restart();
    derivative_.resize(x.size()), new_derivative_.resize(x.size()), end_state_.resize(x.size());
    derivative(x, derivative_, time);
    stepper_.stepper().do_step(derivative, x, derivative_, time, end_state_, new_derivative_, step);
    x = end_state_;
  }

 private:
  using Method = boost::numeric::odeint::runge_kutta_dopri5<State>;
  using ErrorChecker = boost::numeric::odeint::default_error_checker<double, boost::numeric::odeint::range_algebra,
                                                                     boost::numeric::odeint::default_operations>;
  boost::numeric::odeint::controlled_runge_kutta<Method, ErrorChecker, StepSizeController> stepper_;
  State derivative_, new_derivative_, end_state_;
};

}  // namespace balance::control
