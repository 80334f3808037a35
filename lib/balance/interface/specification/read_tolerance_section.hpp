#pragma once
/// `tolerances: {cw1.mass: 1%, "bodies.*.mass": 0.5%, l1: {uniform: 0.1e-3}}`.

#include "balance/interface/specification/study_builder.hpp"

namespace balance::specification {

/// The names of the section, which read_number looks for. Whatever is wrong with them is told later.
/// @param section null if the spec has none
std::set<std::string> list_tolerance_names(const SpecCursor* section);

/// A number that a name of the section calls gets an input of the recording that moves it alone.
/// @param number as it is without that [SI] @param unit that its deviation is told in
Expression register_toleranced_parameter(const SpecCursor& at, StudyBuilder& draft, const Expression& number,
                                         double unit, SignConstraint sign);

/// Once everything that has names has been read.
Tolerances read_tolerances(const SpecCursor& section, StudyBuilder& draft);

}  // namespace balance::specification
