#pragma once
/// Speeds from the command line.

#include "balance/motion/speeds.hpp"
#include "balance/study/study.hpp"

#include <string>
#include <vector>

namespace balance {

/// @param text YAML, with braces or without: `v: tool.u, w: {A: 0.5, B: -0.5}`; what a speed may be made of, and the factors' units:
///        as in a spec's `constraints` (spec/speeds.hpp)
/// @param option what messages call it
/// @throws SpecError whose file is the option
std::vector<GeneralisedSpeed> read_speeds(const std::string& text, const char* option, const Study& study);

}  // namespace balance
