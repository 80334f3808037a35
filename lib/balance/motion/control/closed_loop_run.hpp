#pragma once
/// One run under control: the mechanism moves by its dynamics while a controller tracks a trajectory.

#include "balance/mechanics/results/result.hpp"
#include "balance/mechanics/trajectory/trajectory.hpp"
#include "balance/motion/study/controller_spec.hpp"

#include <functional>

namespace balance::control {

struct ClosedLoopOptions {
  double hold_time =
      0;  ///< additional time to hold the last desired pose, rounded up to whole sample steps, non-negative [s]
  /// Maximum number of integration steps, including rejected ones; 0: 500 000 plus 50 per sample of controller and
  /// result.
  long max_steps = 0;
  /// Called from time to time with the completed fraction of the run, 0 … 1. May be empty.
  std::function<void(double)> progress = {};
};

/// Maximum number of samples of controller and result together.
inline constexpr double max_closed_loop_samples = 2e6;

/// Minimum duration of a run [s].
inline constexpr double min_closed_loop_duration = 1e-12;

/// Computes everything in RunResult at the trajectory's samples. Metrics take both sides of every change of the torque
/// into account. A run that ends early (a singular configuration, a motion that cannot be integrated) has its reason in
/// result.outcome and keeps the rows up to there; a run that cannot start has no rows. If the desired motion is
/// impossible, a controller that does not need it still starts from the trajectory's start; the result then has no
/// quantities that refer to a desired motion.
/// @throws std::invalid_argument if trajectory, controller and mechanism do not match, there are too many samples, or
///        the run is too short
RunResult simulate_closed_loop(const Mechanism& mechanism, const Trajectory& trajectory, const Controller& controller,
                               const ClosedLoopOptions& options = {});

}  // namespace balance::control

namespace balance {

using control::ClosedLoopOptions;
using control::simulate_closed_loop;

}  // namespace balance
