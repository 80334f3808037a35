#pragma once
/// One run under control: the mechanism moves by its own dynamics, a controller leads it along a trajectory.

#include "balance/mechanics/results/result.hpp"
#include "balance/mechanics/trajectory/trajectory.hpp"
#include "balance/motion/study/controller_spec.hpp"

#include <functional>

namespace balance {

struct ClosedLoopOptions {
  double hold_time =
      0;  ///< how much longer the last desired pose is held, rounded up to whole sample steps, not negative [s]
  /// Steps that the integration may take, rejected ones included; 0: 500 000 and 50 for each sample of controller and result.
  long max_steps = 0;
  /// Told now and then which part of the run is done, 0 … 1. May be empty.
  std::function<void(double)> progress = {};
};

/// Samples of the controller and of the result together; more are refused.
inline constexpr double max_closed_loop_samples = 2e6;

/// Shorter runs are refused [s].
inline constexpr double min_closed_loop_duration = 1e-12;

/// Everything of RunResult, on the trajectory's samples; metrics count both sides of every change of the torque. A run that ends early
/// (a singular configuration, a motion that cannot be integrated) has its reason in result.outcome and keeps the rows up to
/// there; one that cannot begin has none. Where the desired motion is impossible, a controller that needs none lets the
/// mechanism go from the trajectory's start all the same; then nothing of what compares with a desired motion is there.
/// @throws std::invalid_argument if trajectory, controller and mechanism do not fit, there are too many samples, or the run is too short
RunResult simulate_closed_loop(const Mechanism& mechanism, const Trajectory& trajectory, const Controller& controller,
                               const ClosedLoopOptions& options = {});

}  // namespace balance
