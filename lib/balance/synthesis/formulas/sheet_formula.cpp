#include "balance/synthesis/formulas/sheet_formula.hpp"

#include <utility>

namespace balance::formulas {

namespace {

/// Where the spec has the formula's name already, it gets another one.
void assign_symbol(Ring& ring, SheetFormula& formula) {
  formula.symbol = ring.add_symbol(formula.label(), SymbolKind::alias, 1);
  const std::string& unique = ring.symbol(formula.symbol).name;
  if (unique != formula.label()) formula.name = unique, formula.indices = "";
}

/// Products of the same entry, or of a multiple of it, become one.
void add_product(std::vector<FormulaProduct>& products, const Polynomial& factor, const Polynomial& entry) {
  for (FormulaProduct& product : products) {
    if (product.factor.size() != entry.size()) continue;
    const Polynomial ratio(entry.terms()[0].coefficient / product.factor.terms()[0].coefficient);
    if (!(ratio * product.factor == entry)) continue;
    product.numerator += ratio * factor;
    return;
  }
  const bool is_negative = entry.terms()[0].coefficient.sign() < 0;
  products.push_back({is_negative ? -factor : factor, 1, is_negative ? -entry : entry});
}

}  // namespace

std::string index_text(const std::vector<std::size_t>& indices, std::size_t count) {
  std::string text;
  for (const std::size_t index : indices) text += (count > 9 && !text.empty() ? "_" : "") + std::to_string(index + 1);
  return text;
}

SheetFormula define_formula(Ring& ring, const std::string& name, const std::string& indices, Polynomial value,
                            Polynomial denominator, const std::string& denominator_name) {
  SheetFormula formula{name, indices, std::move(value), std::move(denominator), denominator_name};
  assign_symbol(ring, formula);
  return formula;
}

void add_multiple(SheetFormula& formula, const Polynomial& factor, const Polynomial& entry) {
  if (factor.is_zero() || entry.is_zero()) return;
  if (factor == Polynomial(1))
    formula.value += entry;
  else if (entry.size() == 1)
    formula.value += factor * entry;
  else
    add_product(formula.products, factor, entry);
}

Polynomial name_sum(Ring& ring, SheetFormula& formula) {
  std::erase_if(formula.products, [](const FormulaProduct& product) { return product.numerator.is_zero(); });
  if (formula.products.empty() && formula.value.size() <= 1) return formula.value;
  assign_symbol(ring, formula);
  return Polynomial::of_symbol(ring, formula.symbol);
}

double evaluate_formula(const SheetFormula& formula, const std::vector<double>& symbols,
                        const std::vector<double>& angles) {
  const auto at = [&](const Polynomial& p) { return p.is_zero() ? 0 : evaluate_polynomial(p, symbols, angles); };
  double value = at(formula.value) / at(formula.denominator);
  for (const FormulaProduct& product : formula.products)
    value += at(product.numerator) / at(product.denominator) * at(product.factor);
  return value;
}

}  // namespace balance::formulas
