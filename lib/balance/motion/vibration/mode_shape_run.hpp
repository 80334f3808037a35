#pragma once
/// A mode as a motion to look at: a run along which the free coordinates move by the mode's shape.

#include "balance/mechanics/results/result.hpp"
#include "balance/motion/vibration/vibration_modes.hpp"

namespace balance::vibration {

/// One period of the oscillation without its decay; of a mode that decays or grows, three times the time of a factor e; of a
/// rigid motion, one second. The driven joints rest at their start. The largest coordinate moves by a tenth of a radian or
/// of a characteristic length, whatever the size of real vibrations, so that efforts have no meaning.
/// @param trajectory with free coordinates, of the modes
/// @return the outcome says if the mechanism cannot follow
/// @throws std::invalid_argument as PartlyDrivenMechanism
RunResult run_mode_shape(const Mechanism& mechanism, const Trajectory& trajectory, const VibrationModes& modes,
                         const VibrationMode& mode);

}  // namespace balance::vibration
