#pragma once
/// Sums of speeds in a spec and on the command line.

#include "balance/interface/specification/study_builder.hpp"

namespace balance::specification {

/// `v: tool.u`, or `w: {A: 0.5, B: -0.5}`: joint coordinates, and components of the motion of the tool (`tool.x`) or of
/// a body's point (`body.point.x`). Velocities: x y z along the world's axes, u v w along the body's. Angular
/// velocities: angle in the plane; in space rx ry rz about the world's axes, p q r about the body's. In a sum with
/// velocities, the factor of an angular velocity is a length per angle.
model::GeneralisedSpeedOf<Expression> read_speed(const Member& member, StudyBuilder& draft);

/// Evaluates the speed at the values with which it was read.
model::GeneralisedSpeed value_of(const model::GeneralisedSpeedOf<Expression>& speed);

}  // namespace balance::specification
