#pragma once
/// Fluctuation of the speed of a machine with one actuator that exerts its mean torque, and the flywheel that limits it.

#include "balance/mechanics/results/result.hpp"

#include <optional>
#include <string>

namespace balance::results {

/// The machine turns about the actuator's coordinate θ: E(θ) = ½ (J(θ) + flywheel) ω² changes by the mean torque less the
/// torque of loads, weight and springs. Exact where these depend on θ alone. With the stated speed ω₀ as the mean of the
/// largest and the smallest speed.
struct SpeedFluctuation {
  std::string coordinate;
  double speed = 0;                  ///< ω₀ [rad/s]
  double mean_torque = 0;            ///< [N m]
  double energy_range = 0;           ///< largest minus smallest E along the turns [J]
  double coefficient = 0;            ///< 2 (ω_max − ω_min)/(ω_max + ω_min) without a flywheel
  double largest = 0, smallest = 0;  ///< speeds without a flywheel, as magnitudes [rad/s]
  std::optional<double> flywheel;    ///< inertia at the coordinate for a stated coefficient [kg m²]; 0: none is needed
};

/// @param stated coefficient for which a flywheel is wanted, positive; none: no flywheel
/// @throws std::invalid_argument as analyse_orders(), or if there is not exactly one actuator, which must turn uniformly,
///         or if the machine would come to rest without a flywheel and none is wanted. The message is suitable for users.
SpeedFluctuation analyse_speed_fluctuation(const RunResult& run, std::optional<double> stated);

}  // namespace balance::results
