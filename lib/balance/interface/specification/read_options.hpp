#pragma once
/// Readers of command-line options.

#include "balance/foundation/base/spelling.hpp"
#include "balance/interface/specification/read_speeds.hpp"
#include "balance/interface/specification/study_builder.hpp"
#include "balance/motion/study/study.hpp"

#include <string>
#include <vector>

namespace balance::specification {

/// Builder of a study, with its units and parameters, whose messages refer to an option.
StudyBuilder make_option_builder(const Study& study, const char* option);

/// Fails for a blank text.
inline void require_text(const std::string& text, const char* what) {
  if (text.find_first_not_of(" \t\r\n") == std::string::npos)
    throw ReadError({}, "", {.expected = what, .found = "an empty text"});
}

// Speeds from the command line.

/// @param text YAML, with or without braces: `v: tool.u, w: {A: 0.5, B: -r}`; terms of a speed and units of factors
/// are as in a spec's `constraints` (interface/specification/read_speeds.hpp), and factors may use its parameters
/// @param option its name in messages
/// @throws SpecError whose file is the option
std::vector<model::GeneralisedSpeed> read_speeds(const std::string& text, const char* option, SpeedUse use,
                                                 const Study& study);

}  // namespace balance::specification
