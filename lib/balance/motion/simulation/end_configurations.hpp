#pragma once
/// Start configuration of a study's mechanism, around which its conditions hold.

#include "balance/mechanics/kinematics/assembly.hpp"
#include "balance/mechanics/trajectory/trajectory.hpp"
#include "balance/motion/study/study.hpp"

#include <vector>

namespace balance::simulation {

/// All coordinates in the trajectory's start pose, in the assembly mode that the spec selects, whether or not the
/// trajectory can be followed; empty if the pose cannot be reached.
std::vector<CoordinateValue> start_coordinates(const Mechanism& mechanism, const Trajectory& trajectory);

/// The same for the first trajectory; empty without trajectories.
std::vector<CoordinateValue> start_coordinates(const Study& study);

/// The mechanism with these coordinates as `assembly`; unchanged if there are none.
Mechanism assembled_at(Mechanism mechanism, const std::vector<CoordinateValue>& coordinates);

// Configurations at the beginning and the end of a trajectory.

/// Computed without a run if the trajectory's `from` determines it.
kinematics::ConfigurationResult find_start_configuration(const Mechanism& mechanism, Trajectory trajectory);

/// In the assembly mode in which a run arrives.
kinematics::ConfigurationResult find_end_configuration(const Mechanism& mechanism, Trajectory trajectory);

}  // namespace balance::simulation
