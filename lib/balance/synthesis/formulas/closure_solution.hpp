#pragma once
/// Loop closures, solved for the rates of the dependent coordinates, and the torques without them.

#include "balance/synthesis/formulas/closure_elimination.hpp"
#include "balance/synthesis/formulas/formula_sheet.hpp"

#include <vector>

namespace balance::formulas {

/// C of the dependent columns: the steps of the elimination, and entries that need none. Rows behind the tree's columns
/// are the rotations of discs (P1 eq. 24).
SheetSection make_solved_section(Ring& ring, const SymbolicEquations& equations, const ClosureElimination& elimination);

/// The torques of the independent coordinates, Σ C_ci τ_c, in the accelerations and rates of all columns:
/// u_i = Σ_j U_ij q̈_j + Σ_jk U_ijk q̇_j q̇_k + U_i (P0 eq. 108, 109). Without loops, U are D.
/// Where C has no closed form, the steps that define it come first.
/// @param solved numbers that are substituted; nullptr: none
SheetSection make_effort_section(Ring& ring, const SymbolicEquations& equations, const ClosureElimination& elimination,
                                 const SolvedConditions* solved);

}  // namespace balance::formulas
