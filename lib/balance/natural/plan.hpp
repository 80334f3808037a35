#pragma once
/// From a trajectory as stated to something that natural coordinates can follow. Private to natural.

#include "balance/motion/motion.hpp"
#include "balance/motion/schedule.hpp"
#include "balance/natural/equations.hpp"

#include <optional>

namespace balance::natural {

struct Plan {
  MotionOutcome outcome;  ///< done: can be followed
  int freedoms = 0;       ///< by rank
  DriveQuantities quantities;
  Coordinates start;  ///< at time 0
  std::optional<Schedule> schedule;
};

/// @param model with all coordinates and angles that the trajectory speaks of
Plan make_plan(const Mechanism& mechanism, const Model& model, const Trajectory& trajectory);

/// The trajectory speaks of the tool's angle, or may come to do so.
bool speaks_of_tool_angle(const Mechanism& mechanism, const Trajectory& trajectory);

}  // namespace balance::natural
