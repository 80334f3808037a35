#pragma once
/// The texts of a spec's numbers, for whoever wants to know the parameters that they are made of.

#include "balance/spec/read_spec.hpp"
#include "balance/study/spec_texts.hpp"

namespace balance {

/// @param text a spec that read_spec takes, with the same options
SpecTexts read_spec_texts(const std::string& text, const ReadOptions& options = {});

}  // namespace balance
