#pragma once
/// The motion that a controller tracks: inverse kinematics of a trajectory at given times.

#include "balance/mechanics/trajectory/motion_source.hpp"
#include "balance/mechanics/trajectory/trajectory.hpp"

#include <vector>

namespace balance::control {

/// @param times increasing, from 0; beyond the trajectory's end its last pose is held
/// @throws std::invalid_argument if trajectory and mechanism do not match
trajectory::MotionTable compute_desired_motion(const Mechanism& mechanism, const Trajectory& trajectory,
                                               const std::vector<double>& times);

/// The start of the mechanism: its coordinates at the trajectory's start, with the tool displaced by the initial error.
/// @param position per coordinate; in: before the displacement, out: after it
/// @return unreachable if the tool cannot get there
MotionOutcome displace_tool(const Mechanism& mechanism, const Trajectory& trajectory, const Vector3& displacement,
                            double angle, VectorX& position);

}  // namespace balance::control
