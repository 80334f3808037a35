#pragma once
/// `design: {choose: {counterweights: 3}}`: which of the offered elements a design may leave out.

#include "balance/interface/specification/spec_cursor.hpp"
#include "balance/interface/specification/study_builder.hpp"
#include "balance/motion/study/balance_goal.hpp"

#include <vector>

namespace balance::specification {

/// Number of elements to keep per section (counterweights, discs or springs): a number, `least`, or
/// `{from: names, most: one of these}`.
std::vector<study::CardinalityRequest> read_cardinality_requests(const SpecCursor& at, StudyBuilder& draft);

/// Finds the text of the elements that the study's choices offer; of all elements of a section if a choice names none.
/// @param root document of the spec's text
void find_optional_element_texts(const YamlNode& root, Study& study);

/// Adds the limits of a design that keep springs within their travel along all motions that its figures name or, if
/// they name none, along all that the spec declares.
void limit_spring_travel(Study& study);

// Figures of a trade-off.

/// A list of two or three figures, each as in `minimize`, or {of: such a list, points: number of designs}.
study::ParetoRequest read_pareto_request(const SpecCursor& at, StudyBuilder& draft);

// Goals of balancing, in specs and suites.

/// One goal or a list of different ones: names, or `{orders: {shaking_force: [1, 2]}, along: run}`. Fails at the cursor's
/// place if it is none.
/// @param study with the mechanism and the trajectories that the goals may name; null: not known yet, names are not
/// checked
std::vector<Goal> read_goals(const SpecCursor& at, const Study* study = nullptr);

}  // namespace balance::specification
