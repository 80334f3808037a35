#pragma once
/// Places that a spec names. Private to the readers.

#include "balance/spec/draft.hpp"

namespace balance::specification {

/// The name of a counterweight, payload or disc, or `body.point`, `body.com`, `body.origin`.
Landmark read_landmark(const SpecCursor& at, const StudyBuilder& draft);

}  // namespace balance::specification
