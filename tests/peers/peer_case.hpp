#pragma once
/// A spec's mechanism moved along a trajectory by balance, with the same states in the coordinates of the tree.

#include "read_rigid_tree.hpp"

#include "balance/mechanics/results/result.hpp"
#include "balance/motion/study/study.hpp"

#include <string>

namespace balance::peers {

struct PeerCase {
  std::string name;     ///< the file's, without folder and ending, and what was removed
  Mechanism mechanism;  ///< without springs, loads, friction and temporary payloads
  Trajectory motion;
  RigidTree tree;
  RunResult run;
  Samples x, dx, ddx;  ///< samples × motions of the tree
};

/// Reads the spec and runs its first trajectory.
/// @throws NotComparable if the spec has nothing to compare, with the reason
PeerCase read_peer_case(const std::string& path);

}  // namespace balance::peers
