#pragma once
/// `workspace`: a box of poses in which figures are taken at rest.

#include "balance/interface/specification/study_builder.hpp"

namespace balance::specification {

/// The name of the trajectory that a workspace is.
inline constexpr const char* workspace_name = "workspace";

/// Adds a trajectory that stops at every pose of the box's grid, row by row, and moves from one to the next between its samples. It goes
/// to and fro so often that no figure asks for steps between the samples (mechanics/trajectory/time_grid.hpp); every pose is then as many
/// samples as any other, by the trapezoidal rule, and the averages are those of the poses.
/// Keys: `tool` and, planar, `angle` or, spatial, `rpy` or `quaternion`; or `joints`; `samples`.
void read_workspace(const SpecCursor& at, StudyBuilder& draft);

}  // namespace balance::specification
