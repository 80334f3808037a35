#pragma once
/// The closures of loops, solved for the rates of some coordinates. Private to formulas.

#include "balance/formulas/sheet.hpp"

namespace balance::formulas {

/// More equations are not solved: the determinant becomes longer than the closures.
inline constexpr std::size_t max_solved_closures = 4;

/// q̇ of dependent columns = C · q̇ of independent ones, by Cramer's rule; a formula for the determinant first. Nothing where there
/// are more than max_solved_closures equations, or not as many as dependent columns.
/// @param independent columns
std::vector<SheetFormula> solve_closures(const SymbolicEquations& equations, const std::vector<int>& independent);

/// Sums of angles around a loop written with the angle of the joint that closes it, where that is shorter.
Polynomial shorten_angle_sums(const SymbolicTree& tree, const Polynomial& p);

}  // namespace balance::formulas
