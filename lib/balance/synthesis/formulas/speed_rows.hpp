#pragma once
/// Chosen speeds (quasi-velocities) as rows in the rates of a tree's coordinates.

#include "balance/synthesis/formulas/sheet_formula.hpp"
#include "balance/synthesis/formulas/symbolic_equations.hpp"

#include <vector>

namespace balance::formulas {

struct SpeedRows {
  Matrix rows;                            ///< speeds × columns
  std::vector<SheetFormula> definitions;  ///< of symbols in them: the total mass mt
};

/// @param speeds of the mechanism whose tree the equations are of
/// @throws FormulaError for a speed that has no formula
SpeedRows derive_speed_rows(Ring& ring, const SymbolicEquations& equations,
                            const std::vector<model::GeneralisedSpeed>& speeds);

}  // namespace balance::formulas
