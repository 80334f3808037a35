#pragma once
/// A formula with its name.

#include "balance/synthesis/formulas/symbolic_polynomial.hpp"

#include <cstddef>
#include <string>
#include <vector>

namespace balance::formulas {

/// One product of a sum: numerator / denominator · factor.
struct FormulaProduct {
  Polynomial numerator, denominator, factor;
};

/// name = value, name = value / denominator, or value = 0 if the name is empty. Products are added to the value.
struct SheetFormula {
  std::string name;     ///< `D`, `C`, …; empty: a condition
  std::string indices;  ///< `12`, or `1_10` if there are more than nine
  Polynomial value;
  Polynomial denominator = 1;
  std::string denominator_name;  ///< of a denominator that has a formula of its own
  std::vector<FormulaProduct> products = {};
  int symbol = -1;  ///< in the ring, of a step: others refer to this formula by it

  std::string label() const { return name + indices; }
};

/// `12`, `1_10`.
std::string index_text(const std::vector<std::size_t>& indices, std::size_t count);

/// A formula to which later ones refer by a symbol of its own. Where the spec has that name already, it gets another one.
SheetFormula define_formula(Ring& ring, const std::string& name, const std::string& indices, Polynomial value,
                            Polynomial denominator = 1, const std::string& denominator_name = "");

/// Adds factor · entry: expanded if one of them is a single term, else as a product, which is added to those of the same entry.
void add_multiple(SheetFormula& formula, const Polynomial& factor, const Polynomial& entry);

/// The value if it is a single term, else a symbol of its own, which the formula then defines.
Polynomial name_sum(Ring& ring, SheetFormula& formula);

double evaluate_formula(const SheetFormula& formula, const std::vector<double>& symbols,
                        const std::vector<double>& angles);

}  // namespace balance::formulas
