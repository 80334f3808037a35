#pragma once
/// Fluctuation of the speed of a machine with one actuator that exerts its mean torque, and the flywheel that limits it.

#include "balance/mechanics/results/result.hpp"

#include <limits>
#include <optional>
#include <string>

namespace balance::results {

/// The motion of a coordinate θ that turns at constant speed by whole turns.
struct UniformTurning {
  std::string coordinate;  ///< "A"; θ is its value
  double speed = 0;        ///< ω₀ [rad/s], of any sign
  int turns = 0;           ///< of the whole run
};

/// E(θ) = ½ (J(θ) + flywheel) ω² changes by the mean torque less the torque of loads, weight and springs. Exact where these
/// depend on θ alone. |ω₀| is the mean of the largest and the smallest speed.
struct SpeedFluctuation {
  double mean_torque = 0;   ///< [N m]
  double energy_range = 0;  ///< largest minus smallest E along the turns, without a flywheel [J]
  /// Without a flywheel; NaN if the machine comes to rest: 2 (ω_max − ω_min)/(ω_max + ω_min), and the speeds as magnitudes
  /// [rad/s].
  double coefficient = std::numeric_limits<double>::quiet_NaN(), largest = coefficient, smallest = coefficient;
  std::optional<double> flywheel;  ///< inertia at the coordinate for a stated coefficient [kg m²]; 0: none is needed
};

/// @param turning of the run, whose quantities repeat
/// @param stated coefficient for which a flywheel is wanted, positive; none: no flywheel
/// @return none, without a stated coefficient, where there is one to refuse
/// @throws std::invalid_argument for a stated coefficient if the only actuator is not the turning one, or nothing has mass.
///         The message is suitable for users.
std::optional<SpeedFluctuation> analyse_speed_fluctuation(const RunResult& run, const UniformTurning& turning,
                                                          std::optional<double> stated);

}  // namespace balance::results
