#pragma once
/// The equation of motion as formulas in chosen speeds (quasi-velocities, P0 eq. 1).
///
/// With p = W(q) q̇ and q̇ = V σ, σ the independent ones of the speeds p, the tree's equations τ = D q̈ + D(q̇, q̇) + z give
///
///     Vᵀ τ = M σ̇ + w(σ, σ) + Vᵀ z,   M = Vᵀ D V,   w_k = Σ V_ik D_ijl (Vσ)_j (Vσ)_l − Σ M_ki Ẇ_i V σ,
///
/// and all speeds are p = C σ, ṗ = C σ̇ + c(σ, σ).
///
/// With loops, q are the independent coordinates, D and z are M̂, D̂ and ẑ of the reduced equations. The tree's coordinates
/// y have ẏ = C q̇ and ÿ = C q̈ + c(q̇, q̇), so that speeds p = W̃ ẏ have W = W̃ C, and Ẇ_i q̇ becomes
///
///     N_i(q̇, q̇) = Σ W̃_ia c_a(q̇, q̇) + W̃̇_i C q̇,   w_k = Σ_jl H_kjl V_jr V_ls,   H_k = Σ V_ik D̂_i − Σ M_ki N_i.

#include "balance/synthesis/formulas/reduced_equations.hpp"
#include "balance/synthesis/formulas/sheet_formula.hpp"
#include "balance/synthesis/formulas/symbolic_equations.hpp"

#include <string>
#include <vector>

namespace balance::formulas {

struct SpeedFormulas {
  std::vector<std::string> names;  ///< of all speeds
  std::vector<int> independent;    ///< indices of the speeds σ
  Matrix W;                        ///< all speeds × coordinates: columns, with loops the independent ones
  /// In the order in which they depend on each other: entries of D and of V, the determinant Delta, the total mass mt,
  /// M; with loops, those of the reduced equations and of W, N and H, too. Polynomials contain their symbols.
  std::vector<SheetFormula> definitions;
  std::vector<Polynomial> divisors;  ///< where one vanishes, the speeds do not determine the motion
  Matrix V, M;                       ///< coordinates × independent, independent × independent
  std::vector<Matrix> w;             ///< w[k][r][s], symmetric in r and s
  Row z;
  Matrix C;               ///< dependent speeds × independent
  std::vector<Matrix> c;  ///< of the dependent speeds
  /// In formulas. With loops, C and c are those of the closures, W1, W2, … of their elimination.
  std::string W_name = "W", C_name = "C", c_name = "c";

  bool is_independent(std::size_t speed) const;
};

/// @param speeds of the mechanism whose tree the equations are of
/// @param reduced of a mechanism with loops; else nullptr
/// @throws FormulaError for anything that has no formula
SpeedFormulas derive_speed_formulas(Ring& ring, const SymbolicEquations& equations,
                                    const std::vector<model::GeneralisedSpeed>& speeds,
                                    const ReducedEquations* reduced = nullptr);

/// Adds the values of the definitions' symbols to those of all symbols.
void evaluate_definitions(const SpeedFormulas& formulas, std::vector<double>& symbols,
                          const std::vector<double>& angles);

}  // namespace balance::formulas
