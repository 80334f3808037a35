#pragma once
/// Modes, stability and response over a range of speeds or of any other number.

#include "balance/motion/simulation/simulate.hpp"
#include "balance/motion/vibration/forced_response.hpp"
#include "balance/motion/vibration/vibration_modes.hpp"

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace balance::vibration {

/// The mechanism and its trajectory at one value of what is swept.
struct SweptCase {
  Mechanism mechanism;
  std::optional<Trajectory> trajectory;  ///< none: as assembled
};

struct SweepOptions {
  std::vector<double> values;  ///< increasing, at least two
  int exact_count = 5;         ///< evenly chosen values at which the response is also computed exactly
  int highest_order = 4;
};

struct SweepPoint {
  double value = 0;
  VibrationModes modes;
  std::optional<ForcedResponse> response;  ///< where driven joints make whole turns
};

/// Where an eigenvalue crosses the imaginary axis.
struct StabilityChange {
  double value = 0;
  bool is_unstable_above = false;   ///< more growing motions above than below
  std::complex<double> eigenvalue;  ///< there; of an oscillation or, without imaginary part, of a divergence
};

/// Where an order's frequency n ω is that of a mode.
struct CriticalSpeed {
  double value = 0;
  double order = 0;
  double frequency = 0;      ///< [Hz]
  double damping_ratio = 0;  ///< of the mode there
};

struct SpeedSweep {
  std::vector<SweepPoint> points;
  std::vector<StabilityChange> stability_changes;  ///< by increasing value, between neighbouring points
  std::vector<CriticalSpeed> critical_speeds;      ///< likewise
};

/// @param case_at for values between the first and the last
/// @throws std::invalid_argument as find_forced_response()
SpeedSweep sweep_speeds(const std::function<SweptCase(double value)>& case_at, const SweepOptions& options,
                        const simulation::Progress& progress = {});

/// The trajectory with its first joint that turns at another constant speed, all others in proportion.
/// @param speed of the same sign [rad/s]
Trajectory change_speed(const Trajectory& trajectory, const results::UniformTurning& turning, double speed);

}  // namespace balance::vibration
