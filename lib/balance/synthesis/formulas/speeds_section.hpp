#pragma once
/// The section of the equations of motion in chosen speeds.

#include "balance/synthesis/formulas/formula_sheet.hpp"

namespace balance::formulas {

/// What other sections define is not repeated.
/// @param sheet has the other sections and speeds
SheetSection make_speeds_section(const FormulaSheet& sheet);

}  // namespace balance::formulas
