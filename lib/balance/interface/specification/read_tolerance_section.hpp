#pragma once
/// `tolerances: {cw1.mass: 1%, "bodies.*.mass": 0.5%, l1: {uniform: 0.1e-3}}`.

#include "balance/interface/specification/study_builder.hpp"

namespace balance::specification {

/// The names in the section, for read_number(). Mistakes in them are reported later.
/// @param section null if the spec has none
std::set<std::string> list_tolerance_names(const SpecCursor* section);

/// If the section names a number, gives it an input of the recording that changes it alone.
/// @param number its unperturbed expression [SI] @param dimension of its deviation
Expression register_toleranced_parameter(const SpecCursor& at, StudyBuilder& draft, const Expression& number,
                                         Dimension dimension, SignConstraint sign);

/// Call it once everything that has a name has been read.
Tolerances read_tolerances(const SpecCursor& section, StudyBuilder& draft);

}  // namespace balance::specification
