#pragma once
/// `workspace`: a box of poses at which figures are evaluated at rest.

#include "balance/interface/specification/study_builder.hpp"

namespace balance::specification {

/// Name of the trajectory that represents a workspace.
inline constexpr const char* workspace_name = "workspace";

/// Adds a trajectory that stops at every pose of the box's grid, row by row, and moves from one to the next
/// between its samples. It goes back and forth so often that no figure asks for steps between the samples
/// (mechanics/trajectory/time_grid.hpp). By the trapezoidal rule every pose then has the same weight, and
/// averages are those of the poses.
/// Keys: `tool` and, planar, `angle` or, spatial, `rpy` or `quaternion`; or `joints`; `samples`.
void read_workspace(const SpecCursor& at, StudyBuilder& draft);

}  // namespace balance::specification
