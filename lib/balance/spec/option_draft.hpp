#pragma once
/// What options of the command line are read with. Private to spec.

#include "balance/base/nearest.hpp"
#include "balance/spec/draft.hpp"

#include <string>

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
