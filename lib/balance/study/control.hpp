#pragma once
/// One run under control: the mechanism moves by its own dynamics, a controller leads it along a trajectory.

#include "balance/control/controller.hpp"
#include "balance/motion/trajectory.hpp"
#include "balance/study/result.hpp"

namespace balance {

struct ControlOptions {
  double settle =
      0;  ///< how much longer the last desired pose is held, rounded up to whole sample steps, not negative [s]
};

/// Samples of the controller and of the result together; more are refused.
inline constexpr double most_control_steps = 2e6;

/// Everything of Result, on the trajectory's samples; metrics count both sides of every change of the torque. A run that ends early
/// (a singular configuration, a motion that cannot be integrated) has its reason in result.outcome and keeps the rows up to
/// there; one that cannot begin has none.
/// @throws std::invalid_argument if trajectory, controller and mechanism do not fit, or there are too many steps
Result control(const Mechanism& mechanism, const Trajectory& trajectory, const Controller& controller,
               const ControlOptions& options = {});

}  // namespace balance
