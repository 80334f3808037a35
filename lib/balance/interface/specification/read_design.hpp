#pragma once
/// `design: {choose: {counterweights: 3}}`: which of the offered elements a design may leave out.

#include "balance/interface/specification/spec_cursor.hpp"
#include "balance/interface/specification/study_builder.hpp"
#include "balance/motion/study/balance_goal.hpp"

#include <vector>

namespace balance::specification {

/// Per section of counterweights, discs or springs how many are kept: a number, `least`, or `{from: names, most: one of these}`.
std::vector<CardinalityRequest> read_cardinality_requests(const SpecCursor& at, StudyBuilder& draft);

/// Finds where in the text the elements stand that the study's choices offer; all of a section's where a choice names none.
/// @param root the spec's document, of its text
void find_optional_element_texts(const YamlNode& root, Study& study);

// Which figures a trade-off is between.

/// A list of two or three figures, each as `minimize` has it, or {of: such a list, points: how many designs}.
ParetoRequest read_pareto_request(const SpecCursor& at, StudyBuilder& draft);

// What to balance for, as specs and suites say it.

/// One goal or a list of different ones; a fault at the cursor's place if it is neither.
std::vector<Goal> read_goals(const SpecCursor& at);

}  // namespace balance::specification
