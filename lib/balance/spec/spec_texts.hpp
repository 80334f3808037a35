#pragma once
/// What a spec says about its numbers.

#include "balance/spec/read_spec.hpp"
#include "balance/study/spec_texts.hpp"

namespace balance {

/// @param options those that the space was read with
SpecNumberTexts read_spec_number_texts(const DesignSpace& space, const ReadOptions& options = {});

}  // namespace balance
