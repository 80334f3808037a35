#pragma once
/// `design: {all_different: [crank1.angle, crank2.angle]}`.

#include "balance/interface/specification/study_builder.hpp"

#include <vector>

namespace balance::specification {

/// Reads a list of numbers that must have different sizes, or a list of such lists. Call it after `choose` and `adapt`.
std::vector<DifferentPaths> read_all_different(const SpecCursor& at, const StudyBuilder& draft);

}  // namespace balance::specification
