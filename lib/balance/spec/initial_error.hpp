#pragma once
/// By how much a controlled run starts away from where it should.

#include "balance/spec/draft.hpp"

namespace balance::specification {

/// `{joints: {A1: 0.05}}` or `{tool: [0.01, 0]}`, in the plane with `angle`.
void read_initial_error(const SpecCursor& at, StudyBuilder& draft, InitialError& error);

}  // namespace balance::specification
