#pragma once
/// Sums of speeds in a spec and on the command line.

#include "balance/interface/specification/study_builder.hpp"

namespace balance::specification {

inline constexpr const char* constraint_value_key = "value";
/// The time [s] in the value of a constraint.
inline constexpr const char* time_name = "t";

/// Quasi-velocities may contain the velocity of the centre of mass and factors that depend on the pose; constraints may
/// have a value.
enum class SpeedUse { quasi_velocity, constraint };

/// `v: tool.u`, or `w: {A: 0.5, B: -0.5}`: joint coordinates, and components of the motion of the tool (`tool.x`) or of
/// a body's point (`body.point.x`). Velocities: x y z along the world's axes, u v w along the body's. Angular
/// velocities: angle in the plane; in space rx ry rz about the world's axes, p q r about the body's. `com.x`, y and z
/// are the velocity of the centre of mass. In a sum with velocities, the factor of an angular velocity is a length per
/// angle.
model::GeneralisedSpeedOf<Expression> read_speed(const Member& member, SpeedUse use, StudyBuilder& draft);

/// Evaluates the speed at the values with which it was read.
model::GeneralisedSpeed to_numbers(const model::GeneralisedSpeedOf<Expression>& speed);

}  // namespace balance::specification
