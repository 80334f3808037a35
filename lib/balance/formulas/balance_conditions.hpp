#pragma once
/// What must vanish for a mechanism without loops to be balanced, with symbols for its lengths. Private to formulas.

#include "balance/formulas/sheet.hpp"

namespace balance::formulas {

/// Rows that must vanish for polynomials to vanish at every pose: the coefficients of all waves, without common lengths, each once,
/// none a combination of shorter ones as far as that is seen.
std::vector<Polynomial> extract_conditions(const std::vector<Polynomial>& entries);

/// One section for each goal: static, force, gyroscopic, decoupled.
std::vector<SheetSection> make_condition_sections(const SymbolicEquations& equations);

}  // namespace balance::formulas
