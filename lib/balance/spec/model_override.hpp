#pragma once
/// What a controller believes of the mechanism where that is not the truth. Private to the readers.

#include "balance/spec/draft.hpp"

namespace balance::specification {

/// `model: {without: [cargo], mass_scale: 0.9, set: {m1: 2, bodies.link2.mass: 1.5}}`.
/// @param root, overrides of the whole spec, which has been read without a mistake
Mechanism read_controller_model(const SpecCursor& at, const YamlNode& root, const SpecParameters::Overrides& overrides,
                                StudyBuilder& draft);

}  // namespace balance::specification
