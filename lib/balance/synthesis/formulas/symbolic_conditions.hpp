#pragma once
/// Balancing conditions as polynomials in the numbers of the spec.

#include "balance/motion/study/balance_goal.hpp"
#include "balance/synthesis/conditions/coefficient_names.hpp"
#include "balance/synthesis/formulas/formula_sheet.hpp"

#include <vector>

namespace balance::formulas {

/// Rows that must vanish for polynomials to vanish at every pose: the coefficients of all waves, without common lengths
/// and without duplicates. Combinations of shorter rows are removed as far as they are recognised.
std::vector<Polynomial> extract_conditions(const std::vector<Polynomial>& entries);

/// One section per goal: static, force, gyroscopic, decoupled.
/// @param equations of a mechanism without loops
std::vector<SheetSection> make_condition_sections(const SymbolicEquations& equations);

/// Whether the joints close no loop and constrain no speeds.
bool is_open_chain(const Mechanism& mechanism);

/// Whether the conditions of these goals are coefficients of the equations of motion: those of an open chain with
/// actuators at all coordinates, without loads and friction.
bool has_symbolic_conditions(const Mechanism& mechanism, const std::vector<Goal>& goals);
/// @throws FormulaError if they are too long
std::vector<Polynomial> derive_symbolic_conditions(const SymbolicEquations& equations, const std::vector<Goal>& goals);

struct ConvertedConditions {
  std::vector<Polynomial> conditions;
  std::vector<int> unnamed;  ///< symbols of coefficients that no formula explains
};
/// Conditions that were derived numerically, for any mechanism and goal. Masses, first moments and inertias become those
/// of the spec's numbers; coefficients without a formula become symbols c1, c2, …
/// @throws FormulaError for known terms
ConvertedConditions convert_conditions(Ring& ring, const SymbolicTree& tree, const Conditions& conditions,
                                       const conditions::ConditionNames& names);

}  // namespace balance::formulas
