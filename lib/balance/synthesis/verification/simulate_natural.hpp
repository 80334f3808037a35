#pragma once
/// The same run with the second formulation.

#include "balance/mechanics/model/mechanism.hpp"
#include "balance/mechanics/trajectory/trajectory.hpp"
#include "balance/motion/simulation/simulate.hpp"
#include "balance/synthesis/verification/natural_model.hpp"

namespace balance::verification {

/// A start configuration for the second formulation.
struct NaturalStart {
  MotionOutcome outcome;  ///< done, or why there is none
  natural::InitialCoordinates start;
};

/// The trajectory's start according to the first formulation: the assembly mode and the whole turns of all coordinates.
/// The second formulation corrects everything else.
/// @throws std::invalid_argument as simulate
NaturalStart find_natural_start(const Mechanism& mechanism, const Trajectory& trajectory);

/// A configuration near the `assembly` values at which the first formulation can close the loops.
NaturalStart find_natural_start(const Mechanism& mechanism);

/// Moves a planar mechanism along the trajectory in natural coordinates. RunResult lacks joint_force, joint_moment,
/// mobility.
/// @throws std::invalid_argument as simulate, and if the mechanism is spatial
RunResult simulate_natural(const Mechanism& mechanism, const Trajectory& trajectory,
                           const simulation::Progress& progress = {});

}  // namespace balance::verification
