#pragma once
/// How the spec's text becomes that of the designed mechanism.

#include "balance/interface/specification/study_builder.hpp"

namespace balance::specification {

/// Moves the draft's free numbers into the study, in the document's order and with their spans, and fills Study::rewrites. A free
/// number is replaced where it stands, its anchor with it; comments stay. An alias is written out if what it repeats holds
/// a free number (its own one then) or is going to change.
/// @param root of study.spec_text, which the draft was read from
void list_text_replacements(const YamlNode& root, StudyBuilder& draft);

}  // namespace balance::specification
