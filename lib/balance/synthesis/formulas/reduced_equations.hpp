#pragma once
/// The equations of motion in the independent coordinates, with the closures' accelerations.

#include "balance/synthesis/formulas/closure_elimination.hpp"
#include "balance/synthesis/formulas/formula_sheet.hpp"

namespace balance::formulas {

/// u_i = Σ M̂_ij q̈_j + Σ D̂_ijk q̇_j q̇_k + ẑ_i (P0 eq. 62, 63), M̂ = Cᵀ M C, ẑ = Cᵀ z and
/// D̂_ijk = Σ C_ai (Σ D_abc C_bj C_ck + Σ M_ab c_bjk), after the steps that define C and c. Long entries of M, D and z are
/// referred to by their names, and are defined first.
/// @param elimination derives its accelerations here
/// @param has_rates another section has the steps that define C
SheetSection make_reduced_section(Ring& ring, const SymbolicEquations& equations, ClosureElimination& elimination,
                                  bool has_rates);

/// The size of that section for mechanisms that are too large to try.
std::size_t estimate_reduced_terms(const SymbolicEquations& equations, std::size_t independent);

/// `A1, A2`.
std::string independent_names(const SymbolicEquations& equations, const std::vector<int>& independent);

}  // namespace balance::formulas
