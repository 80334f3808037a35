#pragma once
/// `design: {for: …, across: …, adapt: …}`.

#include "balance/interface/specification/study_builder.hpp"

namespace balance::specification {

/// The names under `design: for`, which read_number looks for. Whatever is wrong with them is told later.
/// @param design null if the spec has none
std::set<std::string> list_load_names(const SpecCursor* design);

/// A number of the mechanism that `for` may name becomes an input of the recording if it does.
/// @param number its own value [SI]; @param unit that its values in the cases are told in
Expression register_load_parameter(const SpecCursor& at, StudyBuilder& draft, const Expression& number, double unit,
                                   SignConstraint sign);

/// What a free number at a path is to `for`: nothing that it may name.
void register_free_load_name(const std::string& path, StudyBuilder& draft);

/// @param at the mapping or the list under `for`
void read_load_cases(const SpecCursor& at, StudyBuilder& draft, LoadCases& cases);
CaseAggregation read_case_aggregation(const SpecCursor& at);
/// Names of free numbers, or of what holds some. @return their paths
std::set<std::string> read_adapted(const SpecCursor& at, const StudyBuilder& draft);

}  // namespace balance::specification
