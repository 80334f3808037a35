#pragma once
/// The motion that a controller is to follow: a trajectory's inverse kinematics at given times.

#include "balance/mechanics/trajectory/motion_outcome.hpp"
#include "balance/mechanics/trajectory/trajectory.hpp"

#include <vector>

namespace balance {

/// Row k at time[k]. At a jump of the acceleration the side just after it.
struct DesiredMotion {
  MotionOutcome outcome;
  double duration = 0;    ///< of the trajectory [s]
  Eigen::Index rows = 0;  ///< that hold something: all if the outcome is done, those before its end else
  Samples position, velocity, acceleration;  ///< rows × coordinates of the mechanism; angles run on past ±π
  Samples tool_position;                     ///< rows × 3 [m]; empty without a tool
  VectorX tool_angle;                        ///< planar [rad]
  std::vector<Matrix3> tool_rotation;        ///< spatial
};

/// How long the trajectory takes [s]: its own duration, or its table's.
double find_trajectory_duration(const Trajectory& trajectory);

/// @param times increasing, from 0; beyond the trajectory's end its last pose is held
/// @throws std::invalid_argument if trajectory and mechanism do not fit
DesiredMotion compute_desired_motion(const Mechanism& mechanism, const Trajectory& trajectory,
                                     const std::vector<double>& times);

/// The pose that the trajectory starts from, whether it can be followed or not.
/// @param position on return, per coordinate
MotionOutcome solve_start_position(const Mechanism& mechanism, const Trajectory& trajectory, VectorX& position);

/// Where the mechanism starts: its coordinates at the trajectory's start, moved by the initial error's tool displacement.
/// @param position per coordinate; in: where the displacement begins, out: where it ends
/// @return unreachable if the tool cannot get there
MotionOutcome displace_tool(const Mechanism& mechanism, const Trajectory& trajectory, const Vector3& displacement,
                            double angle, VectorX& position);

}  // namespace balance
