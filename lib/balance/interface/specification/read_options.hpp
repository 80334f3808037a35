#pragma once
/// What options of the command line are read with.

#include "balance/foundation/base/spelling.hpp"
#include "balance/interface/specification/study_builder.hpp"
#include "balance/mechanics/model/mechanism.hpp"
#include "balance/motion/study/study.hpp"

#include <string>
#include <vector>

namespace balance::specification {

/// A draft of the study with its units, whose complaints are about an option.
inline StudyBuilder make_option_builder(const Study& study, const char* option) {
  StudyBuilder draft(study.spec_file);
  draft.study = study;
  draft.mechanism() = convert_mechanism<Expression>(study.mechanism, [](double x) { return Expression(x); });
  static_cast<DisplayUnits&>(draft.units) = study.mechanism.units;
  draft.problems = SpecErrorCollector::of_option(option);
  return draft;
}

/// Fails unless there is anything to read.
inline void require_text(const std::string& text, const char* what) {
  if (text.find_first_not_of(" \t\r\n") == std::string::npos)
    throw ReadError({}, "", {.expected = what, .found = "an empty text"});
}

}  // namespace balance::specification

namespace balance {

// Speeds from the command line.

/// @param text YAML, with braces or without: `v: tool.u, w: {A: 0.5, B: -0.5}`; what a speed may be made of, and the factors' units:
///        as in a spec's `constraints` (interface/specification/read_speeds.hpp)
/// @param option what messages call it
/// @throws SpecError whose file is the option
std::vector<GeneralisedSpeed> read_speeds(const std::string& text, const char* option, const Study& study);

}  // namespace balance
