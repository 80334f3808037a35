#pragma once
/// Loop closures, solved for the rates of the dependent coordinates, and the torques without them.

#include "balance/synthesis/formulas/formula_sheet.hpp"

#include <vector>

namespace balance::formulas {

/// The actuated columns; if these are fewer than the freedoms, the first of the other columns are added.
std::vector<int> list_independent_columns(const Mechanism& mechanism, const SymbolicEquations& equations);

/// q̇ of dependent columns = C · q̇ of independent ones, by Cramer's rule; the determinant has the first formula unless
/// it is a single term. Empty if there are more than four equations, or if their number is not that of the dependent
/// columns.
/// @param independent columns
std::vector<SheetFormula> solve_closures(const SymbolicEquations& equations, const std::vector<int>& independent);

/// Replaces sums of angles around a loop by the angle of the joint that closes it, if that is shorter.
Polynomial shorten_angle_sums(const SymbolicTree& tree, const Polynomial& p);

/// The torques of the independent coordinates, Σ C_ci τ_c, in the accelerations and rates of all columns:
/// u_i = Σ_j U_ij q̈_j + Σ_jk U_ijk q̇_j q̇_k + U_i (P0 eq. 108, 109). Without loops, U are D.
/// @param solved numbers that are substituted; nullptr: none
/// @throws FormulaError if the closures are not solved
SheetSection make_torque_section(const Mechanism& mechanism, const SymbolicEquations& equations,
                                 const SolvedConditions* solved);

}  // namespace balance::formulas
