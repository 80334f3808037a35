#pragma once
/// The same run by the second formulation.

#include "balance/mechanics/model/mechanism.hpp"
#include "balance/mechanics/trajectory/trajectory.hpp"
#include "balance/motion/simulation/simulate.hpp"
#include "balance/synthesis/verification/natural_model.hpp"

namespace balance {

/// A start for the second formulation.
struct NaturalStart {
  MotionOutcome outcome;  ///< done, or why there is none
  natural::InitialCoordinates start;
};

/// Where the first formulation finds the trajectory's start: the assembly mode and the whole turns of all coordinates, nothing
/// that the second would not correct.
/// @throws std::invalid_argument as simulate
NaturalStart find_natural_start(const Mechanism& mechanism, const Trajectory& trajectory);

/// A configuration where the first formulation can close the loops, near the `assembly` values.
NaturalStart find_natural_start(const Mechanism& mechanism);

/// Moves a planar mechanism along the trajectory in natural coordinates. Of RunResult it leaves joint_force, joint_moment and
/// mobility empty.
/// @throws std::invalid_argument as simulate, and if the mechanism is spatial
RunResult simulate_natural(const Mechanism& mechanism, const Trajectory& trajectory, const Progress& progress = {});

}  // namespace balance
