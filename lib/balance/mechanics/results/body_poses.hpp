#pragma once
/// Where every body is during a run, from its joint coordinates.

#include "balance/mechanics/model/mechanism.hpp"
#include "balance/mechanics/results/result.hpp"

namespace balance {

/// Row k of both belongs to result.time[k]; B bodies, the ground among them. World axes.
struct BodyPoses {
  Samples position;     ///< N×3B: the bodies' origins [m]; z = 0 in planar mechanisms
  Samples orientation;  ///< N×4B: unit quaternions w x y z, of the two signs the one that goes on smoothly
};

/// @param result a run of this mechanism that is done
/// @throws std::invalid_argument if the run has other coordinates than the mechanism
BodyPoses body_poses(const Mechanism& mechanism, const RunResult& result);

/// Fills the result's body_names, body_position and body_orientation.
/// @throws std::invalid_argument as body_poses
void add_body_poses(const Mechanism& mechanism, RunResult& result);

}  // namespace balance
