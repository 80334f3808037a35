#pragma once
/// The equations of motion in the independent coordinates, with the closures' accelerations.

#include "balance/synthesis/formulas/closure_elimination.hpp"
#include "balance/synthesis/formulas/sheet_formula.hpp"

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace balance::formulas {

struct SheetSection;

/// u_i = Σ M̂_ij q̈_j + Σ D̂_ijk q̇_j q̇_k + ẑ_i (P0 eq. 62, 63), M̂ = Cᵀ M C, ẑ = Cᵀ z and
/// D̂_ijk = Σ C_ai (Σ D_abc C_bj C_ck + Σ M_ab c_bjk), with ẏ = C q̇ and ÿ = C q̈ + c(q̇, q̇) for the columns y.
struct ReducedEquations {
  std::vector<int> independent;  ///< columns
  std::vector<VectorX> poses;    ///< at which the loops close, per column
  Matrix C;                      ///< columns × independent
  std::vector<Matrix> c;         ///< c[a][j][k], symmetric in j and k
  // In the order in which they depend on each other:
  std::vector<SheetFormula> rate_steps, acceleration_steps;  ///< that define C and c
  std::vector<SheetFormula> definitions;                     ///< of long entries of M, D and z
  std::vector<SheetFormula> formulas;                        ///< M̂, D̂ and ẑ
  /// M̂, D̂ and ẑ: single terms, or symbols that the formulas define.
  Matrix M;
  std::vector<Matrix> D;
  Row z;
};

/// @param elimination derives its accelerations here
ReducedEquations derive_reduced_equations(Ring& ring, const SymbolicEquations& equations,
                                          ClosureElimination& elimination);

/// @param rates_section index of the section that has the steps that define C, if there is one
SheetSection make_reduced_section(const SymbolicEquations& equations, const ReducedEquations& reduced,
                                  std::optional<std::size_t> rates_section);

/// The size of that section for mechanisms that are too large to try.
std::size_t estimate_reduced_terms(const SymbolicEquations& equations, std::size_t independent);

/// `A1, A2`.
std::string independent_names(const SymbolicEquations& equations, const std::vector<int>& independent);

}  // namespace balance::formulas
