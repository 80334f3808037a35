#pragma once
/// Where a study's mechanism starts from: the configuration that its conditions hold around.

#include "balance/mechanics/kinematics/assembly.hpp"
#include "balance/mechanics/trajectory/trajectory.hpp"
#include "balance/motion/study/study.hpp"

#include <vector>

namespace balance {

/// All coordinates at the start of the first trajectory, in the assembly mode that the spec picks; empty without trajectories or
/// if the pose cannot be reached.
std::vector<CoordinateValue> start_coordinates(const Study& study);

/// The mechanism, to be assembled where these coordinates say; as it is if there are none.
Mechanism assembled_at(Mechanism mechanism, const std::vector<CoordinateValue>& coordinates);

// The configurations that a trajectory begins and ends at.

/// Found without a run where the trajectory's `from` tells it.
ConfigurationResult find_start_configuration(const Mechanism& mechanism, const Trajectory& trajectory);

/// In the assembly mode that a run comes in.
ConfigurationResult find_end_configuration(const Mechanism& mechanism, Trajectory trajectory);

}  // namespace balance
