#pragma once
/// One step after another of an ordinary differential equation, with error control: the seam to Boost.Odeint.

#include "balance/foundation/base/elementary.hpp"

#include <boost/numeric/odeint/stepper/controlled_runge_kutta.hpp>
#include <boost/numeric/odeint/stepper/generation/make_controlled.hpp>
#include <boost/numeric/odeint/stepper/runge_kutta_dopri5.hpp>

#include <algorithm>
#include <vector>

namespace balance {

/// How long the next step may be: Odeint's own rule, with powers that are the same on every processor.
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

/// Dormand–Prince 5(4) (J. Comput. Appl. Math. 6, 1980): the derivative at a step's end is the next step's first.
class Integrator {
 public:
  using State = std::vector<double>;

  Integrator(double absolute, double relative) : stepper_(ErrorChecker(absolute, relative), StepSizeController()) {}

  /// The right-hand side has changed: the last derivative is of no use.
  void restart() { stepper_.reset(); }

  /// @param derivative void(const State& x, State& dxdt, double t); may throw to refuse a state: then x and time are as before
  /// @param step its length, on return what to try next
  /// @return false if the error was too large: x and time are as before
  template <class Derivative>
  bool try_step(Derivative&& derivative, State& x, double& time, double& step) {
    return stepper_.try_step(derivative, x, time, step) == boost::numeric::odeint::success;
  }

  /// From x with the derivative there to as much later as one step of this length leads, whatever its error; the next
  /// try_step() begins anew.
  template <class Derivative>
  void step_without_error_control(Derivative&& derivative, State& x, double time, double step) {
    restart();
    slope_.resize(x.size()), new_slope_.resize(x.size()), end_.resize(x.size());
    derivative(x, slope_, time);
    stepper_.stepper().do_step(derivative, x, slope_, time, end_, new_slope_, step);
    x = end_;
  }

 private:
  using Method = boost::numeric::odeint::runge_kutta_dopri5<State>;
  using ErrorChecker = boost::numeric::odeint::default_error_checker<double, boost::numeric::odeint::range_algebra,
                                                                     boost::numeric::odeint::default_operations>;
  boost::numeric::odeint::controlled_runge_kutta<Method, ErrorChecker, StepSizeController> stepper_;
  State slope_, new_slope_, end_;
};

}  // namespace balance
