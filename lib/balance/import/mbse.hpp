#pragma once
/// Planar mechanisms in natural coordinates, as MBSE (multibody state estimation) writes them in YAML.

#include "balance/import/robot.hpp"
#include "balance/spec/cursor.hpp"

namespace balance::foreign {

/// What is fixed is bodies[0]. A body's frame has its origin at its first point and x towards its second one; where bodies share a
/// point there is a revolute joint, `p3_body0_body2`. Coordinates are zero where the file's points are.
/// @param problems collects what is wrong
ForeignModel read_mbse(const specification::SpecCursor& root, const std::string& file);

}  // namespace balance::foreign
