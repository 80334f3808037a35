#pragma once
/// Finds motion laws that depend on the mechanism, such as the fastest within limits or the gentlest for a duration,
/// and paths within a corridor.

#include "balance/mechanics/model/mechanism.hpp"
#include "balance/mechanics/trajectory/motion_outcome.hpp"
#include "balance/mechanics/trajectory/optimised_law.hpp"
#include "balance/mechanics/trajectory/trajectory.hpp"

#include <optional>

namespace balance::time_optimal {

struct ResolvedTrajectory {
  MotionOutcome outcome;                                  ///< done, or why there is no law
  Trajectory trajectory;                                  ///< with the nodes of the law and its duration
  std::optional<trajectory::OptimisedLaw> optimised_law;  ///< none if the law needed no search
  std::optional<trajectory::CorridorResult> corridor;     ///< none without a corridor, or if its path was known
  trajectory::PhasePlane phase_plane;                     ///< only the maximum velocity curve; empty without limits
};

/// Completes a trajectory with a law and a path that can be followed. Parts that need no search, or have been found, do
/// not change; if they have limits, the maximum velocity curve of these is computed. Method and sources:
/// docs/motion.md.
/// @throws std::invalid_argument if the trajectory asks for something that does not exist
ResolvedTrajectory resolve_trajectory(const Mechanism& mechanism, const Trajectory& trajectory);

}  // namespace balance::time_optimal
