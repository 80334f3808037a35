#pragma once
/// Reads back what has been printed.

#include "balance/formulas/rational.hpp"

#include <map>
#include <string>

namespace balance::formulas {

/// The value of a formula as the printer writes it.
/// @param values of all names in it
/// @throws FormulaError if it cannot be read or has a name without a value
double evaluate_text(const std::string& text, const std::map<std::string, double>& values);

}  // namespace balance::formulas
