#pragma once
/// How a trajectory runs through its way.

#include "balance/spec/draft.hpp"

namespace balance::specification {

/// A law's name.
MotionLawKind read_law(const SpecCursor& at);
/// The ramps of a trapezoidal velocity: one number for both, or two. Fails for any other law.
void read_ramps(const SpecCursor& at, StudyBuilder& draft, MotionLawOf<Expression>& law);

}  // namespace balance::specification
