#pragma once
/// From what a reader found to the bodies and joints of a mechanism.

#include "balance/import/import.hpp"
#include "balance/import/robot.hpp"

namespace balance::foreign {

/// Judges masses, chooses motors, merges what is fixed, turns massless bodies between joints into joints. Findings come in the order
/// of the file.
/// @throws SpecError for what a spec cannot say, or if nothing moves
void simplify_model(ForeignModel& robot, const ImportOptions& options);

}  // namespace balance::foreign
