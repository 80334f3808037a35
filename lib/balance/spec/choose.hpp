#pragma once
/// `design: {choose: {counterweights: 3}}`: which of the offered elements a design may leave out.

#include "balance/spec/draft.hpp"

namespace balance::specification {

/// Per section of counterweights, discs or springs how many are kept: a number, `least`, or `{from: names, most: one of these}`.
std::vector<CardinalityRequest> read_cardinality_requests(const SpecCursor& at, StudyBuilder& draft);

/// Finds where in the text the elements stand that the study's choices offer; all of a section's where a choice names none.
/// @param root the spec's document, of its text
void find_optional_element_texts(const YamlNode& root, Study& study);

}  // namespace balance::specification
