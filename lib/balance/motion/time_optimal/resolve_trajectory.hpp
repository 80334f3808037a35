#pragma once
/// Finds the laws of motion that depend on the mechanism: the fastest within limits, the gentlest in a duration; and the way within
/// a corridor.

#include "balance/mechanics/model/mechanism.hpp"
#include "balance/mechanics/trajectory/motion_outcome.hpp"
#include "balance/mechanics/trajectory/optimised_law.hpp"
#include "balance/mechanics/trajectory/trajectory.hpp"

#include <optional>

namespace balance {

struct ResolvedTrajectory {
  MotionOutcome outcome;                      ///< done, or why there is no law
  Trajectory trajectory;                      ///< with the law's nodes and its duration
  std::optional<OptimisedLaw> optimised_law;  ///< nothing if the law needed no search
  std::optional<CorridorResult> corridor;     ///< nothing if there is none, or it had been found before
  PhasePlane phase_plane;                     ///< its ceiling alone; empty if no limits are stated
};

/// The same trajectory with a law and a way that can be followed. Those that need no search, or have been found, stay as they are; what
/// limits beside them would allow is told.
/// Method and sources: docs/motion.md.
/// @throws std::invalid_argument if the trajectory asks for something that does not exist
ResolvedTrajectory resolve_trajectory(const Mechanism& mechanism, const Trajectory& trajectory);

}  // namespace balance
