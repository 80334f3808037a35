#pragma once
/// One run under control: the mechanism moves by its own dynamics, a controller leads it along a trajectory.

#include "balance/motion/trajectory.hpp"
#include "balance/result/result.hpp"
#include "balance/study/controller.hpp"

#include <functional>

namespace balance {

struct ControlOptions {
  double settle =
      0;  ///< how much longer the last desired pose is held, rounded up to whole sample steps, not negative [s]
  /// Steps that the integration may take, rejected ones included; 0: 500 000 and 50 for each sample of controller and result.
  long most_steps = 0;
  /// Told now and then which part of the run is done, 0 … 1. May be empty.
  std::function<void(double)> progress = {};
};

/// Samples of the controller and of the result together; more are refused.
inline constexpr double most_control_steps = 2e6;

/// Shorter runs are refused [s].
inline constexpr double shortest_run = 1e-12;

/// Everything of Result, on the trajectory's samples; metrics count both sides of every change of the torque. A run that ends early
/// (a singular configuration, a motion that cannot be integrated) has its reason in result.outcome and keeps the rows up to
/// there; one that cannot begin has none. Where the desired motion is impossible, a controller that needs none lets the
/// mechanism go from the trajectory's start all the same; then nothing of what compares with a desired motion is there.
/// @throws std::invalid_argument if trajectory, controller and mechanism do not fit, there are too many samples, or the run is too short
Result control(const Mechanism& mechanism, const Trajectory& trajectory, const Controller& controller,
               const ControlOptions& options = {});

}  // namespace balance
