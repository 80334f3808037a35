#pragma once
/// What options of the command line are read with. Private to spec.

#include "balance/base/nearest.hpp"
#include "balance/spec/draft.hpp"

#include <string>

namespace balance::read {

/// A draft of the study with its units, whose complaints are about an option.
inline Draft draft_of(const Study& study, const char* option) {
  Draft draft(study.spec_file);
  draft.study = study;
  draft.mechanism() = converted<Expression>(study.mechanism, [](double x) { return Expression(x); });
  static_cast<SpecUnits&>(draft.units) = study.mechanism.units;
  draft.problems = Problems::of_option(option);
  return draft;
}

/// Fails unless there is anything to read.
inline void need_text(const std::string& text, const char* what) {
  if (text.find_first_not_of(" \t\r\n") == std::string::npos)
    throw Problem({}, "", {.expected = what, .found = "an empty text"});
}

}  // namespace balance::read
