#pragma once
/// Laws of motion by their names.

#include "balance/interface/specification/study_builder.hpp"

namespace balance::specification {

/// Reads a law's name.
MotionLawKind read_law(const SpecCursor& at);
/// The ramps of a trapezoidal velocity: one number for both, or two. Fails for any other law.
void read_ramps(const SpecCursor& at, StudyBuilder& draft, trajectory::MotionLawOf<Expression>& law);

}  // namespace balance::specification
