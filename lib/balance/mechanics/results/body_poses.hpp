#pragma once
/// Poses of all bodies during a run, computed from its joint coordinates.

#include "balance/mechanics/model/mechanism.hpp"
#include "balance/mechanics/results/result.hpp"

namespace balance {

/// Row k of both belongs to result.time[k]; B bodies including the ground. World axes.
struct BodyPoses {
  Samples position;     ///< N×3B: the bodies' origins [m]; z = 0 in planar mechanisms
  Samples orientation;  ///< N×4B: unit quaternions w x y z, with the sign that makes them continuous
};

/// @param result a completed run of this mechanism
/// @throws std::invalid_argument if the numbers of joint coordinates of run and mechanism differ
BodyPoses body_poses(const Mechanism& mechanism, const RunResult& result);

/// Fills the result's body_names, body_position and body_orientation.
/// @throws std::invalid_argument as body_poses
void add_body_poses(const Mechanism& mechanism, RunResult& result);

}  // namespace balance
