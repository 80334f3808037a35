#pragma once
/// What is computed for many samples at once: a table of functions for every instruction set, compiled from one source
/// (cmake/Lanes.cmake). Private to the library.

#include "balance/base/instruction_set.hpp"
#include "balance/kinematics/tree.hpp"

namespace balance {

/// States and torques as tables: one row per state, contiguous in memory, as wide as the tree has coordinates.
struct TorqueJob {
  long count = 0;
  const double *y = nullptr, *dy = nullptr, *ddy = nullptr;
  double* tau = nullptr;  ///< generalised forces [N m or N]
};

struct LaneKernels {
  // As tree_torques (dynamics/recursion.hpp), state by state.
  void (*planar_torques)(const Tree<Planar>& tree, const Vector2& gravity, const TorqueJob& job);
  void (*spatial_torques)(const Tree<Spatial>& tree, const Vector3& gravity, const TorqueJob& job);
};

/// @param set one of instruction_sets(), of which the last is the quickest
/// @throws std::invalid_argument if this machine or this library lacks it
const LaneKernels& lane_kernels(InstructionSet set);

}  // namespace balance
