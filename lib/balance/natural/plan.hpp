#pragma once
/// From a trajectory as stated to something that natural coordinates can follow. Private to natural.

#include "balance/motion/motion.hpp"
#include "balance/motion/schedule.hpp"
#include "balance/natural/equations.hpp"

#include <optional>

namespace balance::natural {

struct NaturalCompiledTrajectory {
  MotionOutcome outcome;  ///< done: can be followed
  int freedoms = 0;       ///< by rank
  DriveQuantities quantities;
  NaturalCoordinates start;  ///< at time 0
  std::optional<PrescribedMotion> schedule;
};

/// @param model with all coordinates and angles that the trajectory speaks of
NaturalCompiledTrajectory compile_natural_trajectory(const Mechanism& mechanism, const NaturalModel& model,
                                                     const Trajectory& trajectory);

/// The trajectory speaks of the tool's angle, or may come to do so.
bool has_tool_angle(const Mechanism& mechanism, const Trajectory& trajectory);

}  // namespace balance::natural
