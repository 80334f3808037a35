#pragma once
/// Bushings: springs and dampers between two bodies in all directions.

#include "balance/interface/specification/study_builder.hpp"

namespace balance::specification {

/// `{m1: {between: [ground.L, frame.L], stiffness: [kx, ky], damping: [cx, cy], angular: {stiffness: k, damping: c}}}`.
/// A bushing is a joint with its name that lets everything move (planar: `planar`, spatial: `free`), with a spring and
/// viscous friction in each of its coordinates: the displacement of the second point along the first body's axes, and
/// the rotation. The springs and the friction are appended by add_dampers(), after those of the spec.
void read_bushings(const SpecCursor& section, StudyBuilder& draft);

/// Appends the springs and dampers that belong to other elements. Dampers of a coordinate are one viscous friction,
/// together with the friction of the spec.
void add_dampers(StudyBuilder& draft);

}  // namespace balance::specification
