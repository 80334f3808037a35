#pragma once
/// The section of the equations of motion in chosen speeds.

#include "balance/synthesis/formulas/formula_sheet.hpp"

namespace balance::formulas {

/// What other sections define is not repeated.
/// @param sheet has the other sections and speeds
/// @param with_tree whether other sections have the terms of the tree
SheetSection make_speeds_section(const FormulaSheet& sheet, bool with_tree);

}  // namespace balance::formulas
