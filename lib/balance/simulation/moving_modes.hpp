#pragma once
/// Which other ways to assemble a mechanism can make a motion that it cannot make as it is.

#include "balance/motion/motion.hpp"
#include "balance/motion/trajectory.hpp"

#include <string>
#include <vector>

namespace balance {

struct MovingModes {
  int others =
      0;  ///< assembly modes at the start pose besides the one that `assembly` picks, as far as they were found
  std::vector<std::vector<CoordinateValue>> moving;  ///< of these, by what picks them: values for `assembly`
};

/// Of a trajectory whose run has failed after its start. Random starts, always the same; each mode's run has two samples.
/// @throws std::invalid_argument as simulate()
MovingModes find_moving_modes(const Mechanism& mechanism, const Trajectory& trajectory);

/// What to say of them after the reason of a failure: "; another assembly mode can make this motion: assembly: {B: -1.2}"; empty if the
/// failure is no matter of modes, or there is one mode only.
/// @param length_unit, angle_unit SI values of the units to say it in
std::string moving_modes_text(const Mechanism& mechanism, const Trajectory& trajectory, const MotionOutcome& outcome,
                              double length_unit, double angle_unit);

}  // namespace balance
