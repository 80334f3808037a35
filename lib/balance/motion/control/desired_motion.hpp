#pragma once
/// The motion that a controller tracks: inverse kinematics of a trajectory at given times.

#include "balance/mechanics/trajectory/motion_outcome.hpp"
#include "balance/mechanics/trajectory/trajectory.hpp"

#include <vector>

namespace balance {

/// Row k at time[k]. At a jump of the acceleration, the value just after it.
struct DesiredMotion {
  MotionOutcome outcome;
  double duration = 0;    ///< of the trajectory [s]
  Eigen::Index rows = 0;  ///< number of valid rows: all if the outcome is done, else those before its end
  Samples position, velocity, acceleration;  ///< rows × coordinates of the mechanism; angles are continuous past ±π
  Samples tool_position;                     ///< rows × 3 [m]; empty without a tool
  VectorX tool_angle;                        ///< planar [rad]
  std::vector<Matrix3> tool_rotation;        ///< spatial
};

/// Duration of the trajectory [s]: its own, or its table's.
double find_trajectory_duration(const Trajectory& trajectory);

/// @param times increasing, from 0; beyond the trajectory's end its last pose is held
/// @throws std::invalid_argument if trajectory and mechanism do not match
DesiredMotion compute_desired_motion(const Mechanism& mechanism, const Trajectory& trajectory,
                                     const std::vector<double>& times);

/// The pose at the start of the trajectory, even if the trajectory cannot be followed.
/// @param position output, per coordinate
MotionOutcome solve_start_position(const Mechanism& mechanism, const Trajectory& trajectory, VectorX& position);

/// The start of the mechanism: its coordinates at the trajectory's start, with the tool displaced by the initial error.
/// @param position per coordinate; in: before the displacement, out: after it
/// @return unreachable if the tool cannot get there
MotionOutcome displace_tool(const Mechanism& mechanism, const Trajectory& trajectory, const Vector3& displacement,
                            double angle, VectorX& position);

}  // namespace balance
