#pragma once
/// Numbers that are legal and that hardly anybody means: mostly those of a unit that was not said.

#include "balance/spec/units.hpp"
#include "balance/study/study.hpp"

#include <string>
#include <vector>

namespace balance::specification {

/// One sentence for every sort of number that is beyond what mechanisms have.
/// @param units in which the study was written
std::vector<std::string> list_implausible_numbers(const Study& study, const Units& units);

}  // namespace balance::specification
