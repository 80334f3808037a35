#include "balance/synthesis/formulas/sheet_formula.hpp"

#include <utility>

namespace balance::formulas {

std::string index_text(const std::vector<std::size_t>& indices, std::size_t count) {
  std::string text;
  for (const std::size_t index : indices) text += (count > 9 && !text.empty() ? "_" : "") + std::to_string(index + 1);
  return text;
}

SheetFormula define_formula(Ring& ring, const std::string& name, const std::string& indices, Polynomial value,
                            Polynomial denominator, const std::string& denominator_name) {
  SheetFormula formula{name, indices, std::move(value), std::move(denominator), denominator_name};
  formula.symbol = ring.add_symbol(formula.label(), SymbolKind::alias, 1);
  const std::string& unique = ring.symbol(formula.symbol).name;
  if (unique != formula.label()) formula.name = unique, formula.indices = "";
  return formula;
}

}  // namespace balance::formulas
