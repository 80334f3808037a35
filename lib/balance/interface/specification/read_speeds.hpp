#pragma once
/// Sums of speeds in a spec and on the command line.

#include "balance/interface/specification/study_builder.hpp"

namespace balance::specification {

/// `v: tool.u`, or `w: {A: 0.5, B: -0.5}`: joint coordinates, and components of the motion of the tool (`tool.x`) or of a body's point
/// (`body.point.x`): x y z along the world's axes, u v w along the body's; angle in the plane, rx ry rz and p q r in space how it turns.
/// Where velocities are added, the factor of what turns is a length per angle.
GeneralisedSpeedOf<Expression> read_speed(const Member& member, StudyBuilder& draft);

/// At the values that it was read with.
GeneralisedSpeed value_of(const GeneralisedSpeedOf<Expression>& speed);

}  // namespace balance::specification
