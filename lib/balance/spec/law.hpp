#pragma once
/// How a trajectory runs through its way.

#include "balance/spec/draft.hpp"

namespace balance::read {

/// A law's name.
LawKind read_law(const Cursor& at);
/// The ramps of a trapezoidal velocity: one number for both, or two. Fails for any other law.
void read_ramps(const Cursor& at, Draft& draft, LawOf<Expression>& law);

}  // namespace balance::read
