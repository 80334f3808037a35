#pragma once
/// Finds the way within a corridor. Private to timing.

#include "balance/model/mechanism.hpp"
#include "balance/motion/found_law.hpp"
#include "balance/motion/motion.hpp"
#include "balance/motion/trajectory.hpp"

#include <optional>

namespace balance {

/// Fills the controls of the trajectory's corridor, so that the duration (law fastest), the least peak in a duration (gentlest) or the
/// peak under a stated law is least. A trajectory without one, or whose way has been found, stays as it is.
/// @return done; or why the path in the corridor's middle cannot be followed or has no law
/// @throws std::invalid_argument if the trajectory asks for something that does not exist
MotionOutcome optimise_corridor_path(const Mechanism& mechanism, Trajectory& trajectory,
                                     std::optional<CorridorResult>& found);

}  // namespace balance
