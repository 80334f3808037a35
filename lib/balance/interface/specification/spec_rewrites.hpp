#pragma once
/// Replacements that turn the spec's text into that of the designed mechanism.

#include "balance/interface/specification/study_builder.hpp"

namespace balance::specification {

/// Moves the draft's free numbers into the study, in document order and with their spans, and fills Study::rewrites. A
/// free number is replaced in its place, together with its anchor; comments stay. An alias is written out if what it
/// repeats contains a free number (which is then its own) or is going to change.
/// @param root document of study.spec_text, from which the draft was read
void list_text_replacements(const YamlNode& root, StudyBuilder& draft);

}  // namespace balance::specification
