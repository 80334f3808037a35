#pragma once
/// `design: {for: …, across: …, adapt: …}`.

#include "balance/interface/specification/study_builder.hpp"

namespace balance::specification {

/// The names under `design: for`, for read_number(). Mistakes in them are reported later.
/// @param design null if the spec has none
std::set<std::string> list_load_names(const SpecCursor* design);

/// If `for` names a number of the mechanism, makes it an input of the recording.
/// @param number its own value [SI] @param dimension of its values in the cases
Expression register_load_parameter(const SpecCursor& at, StudyBuilder& draft, const Expression& number,
                                   Dimension dimension, SignConstraint sign);

/// Registers the path of a free number, which `for` must not name.
void register_free_load_name(const std::string& path, StudyBuilder& draft);

/// @param at the mapping or the list under `for`
void read_load_cases(const SpecCursor& at, StudyBuilder& draft, study::LoadCases& cases);
study::CaseAggregation read_case_aggregation(const SpecCursor& at);
/// Reads names of free numbers, or of elements that contain some. @return the paths of the numbers
std::set<std::string> read_adapted(const SpecCursor& at, const StudyBuilder& draft);

}  // namespace balance::specification
