#pragma once
/// The equation of motion of a mechanism without loops as formulas in chosen speeds (quasi-velocities, P0 eq. 1).
///
/// With p = W(q) q̇ and q̇ = V σ, σ the independent ones of the speeds p, the tree's equations τ = D q̈ + D(q̇, q̇) + z give
///
///     Vᵀ τ = M σ̇ + w(σ, σ) + Vᵀ z,   M = Vᵀ D V,   w_k = Σ V_ik D_ijl (Vσ)_j (Vσ)_l − Σ M_ki Ẇ_i V σ,
///
/// and all speeds are p = C σ, ṗ = C σ̇ + c(σ, σ).

#include "balance/synthesis/formulas/sheet_formula.hpp"
#include "balance/synthesis/formulas/symbolic_equations.hpp"

#include <string>
#include <vector>

namespace balance::formulas {

struct SpeedFormulas {
  std::vector<std::string> names;  ///< of all speeds
  std::vector<int> independent;    ///< indices of the speeds σ
  Matrix W;                        ///< all speeds × columns
  /// In the order in which they depend on each other: entries of D and of V, the determinant Delta, the total mass mt,
  /// M. Polynomials below contain their symbols.
  std::vector<SheetFormula> definitions;
  Matrix V, M;            ///< columns × independent, independent × independent
  std::vector<Matrix> w;  ///< w[k][r][s], symmetric in r and s
  Row z;
  Matrix C;               ///< dependent speeds × independent
  std::vector<Matrix> c;  ///< of the dependent speeds

  bool is_independent(std::size_t speed) const;
};

/// @param speeds of the mechanism whose tree the equations are of
/// @throws FormulaError for a mechanism with loops, or for anything that has no formula
SpeedFormulas derive_speed_formulas(Ring& ring, const SymbolicEquations& equations,
                                    const std::vector<model::GeneralisedSpeed>& speeds);

/// Adds the values of the definitions' symbols to those of all symbols.
void evaluate_definitions(const SpeedFormulas& formulas, std::vector<double>& symbols,
                          const std::vector<double>& angles);

}  // namespace balance::formulas
