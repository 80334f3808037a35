#pragma once
/// Conditions that nobody needs to read because they cannot fail.

#include "balance/conditions/conditions.hpp"

namespace balance {

/// Whether a condition is about discs alone and holds for every disc that is symmetrical about its axis: its CoM lies on the
/// axis, its inertia is the same all round.
bool is_met_by_symmetric_discs(const Conditions& conditions, int row, const Mechanism& mechanism);

}  // namespace balance
