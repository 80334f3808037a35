#include "balance/formulas/printed.hpp"

namespace balance::formulas {

namespace {

std::string text_of(const SheetFormula& formula, FormulaPrinter& printer, const PrintOptions& options) {
  if (options.with_values) {
    const std::string above = printer.print_numbers(formula.value);
    if (formula.denominator == Polynomial(1)) return above;
    const std::string below =
        formula.denominator_name.empty() ? printer.print_numbers(formula.denominator) : formula.denominator_name;
    return options.style == PrintStyle::latex ? "\\frac{" + above + "}{" + below + "}"
                                              : "(" + above + ")/(" + below + ")";
  }
  if (formula.denominator == Polynomial(1)) return printer.print(formula.value);
  if (formula.denominator_name.empty()) return printer.print_ratio(formula.value, formula.denominator);
  const bool latex = options.style == PrintStyle::latex;
  const std::string above = printer.print(formula.value);
  if (latex) return "\\frac{" + above + "}{" + latex_name(formula.denominator_name) + "}";
  return (formula.value.size() > 1 ? "(" + above + ")" : above) + "/" + formula.denominator_name;
}

/// Blocks of natural coordinates are complex numbers.
std::string latex_head(const std::string& name) {
  if (name == "Phi" || name == "Delta") return "\\" + name;
  if (name == "Mre" || name == "Cre") return "\\Re " + name.substr(0, 1);
  if (name == "Mim" || name == "Cim") return "\\Im " + name.substr(0, 1);
  return name;
}

}  // namespace

std::vector<PrintedSection> print_sheet(const FormulaSheet& sheet, const PrintOptions& options) {
  std::vector<PrintedSection> sections;
  FormulaPrinter printer(*sheet.ring, options.style);
  for (const SheetSection& from : sheet.sections) {
    PrintedSection to{from.section, from.heading, {},
                      from.zero,    from.terms,   from.is_too_long || from.terms > options.max_terms};
    for (const SheetFormula& formula : from.formulas)
      if (!to.is_left_out) to.formulas.push_back({formula.label(), text_of(formula, printer, options)});
    sections.push_back(std::move(to));
  }
  return sections;
}

std::map<std::string, std::string> texts_by_label(const std::vector<PrintedSection>& sections) {
  std::map<std::string, std::string> texts;
  for (std::size_t s = 0; s < sections.size(); ++s)
    for (std::size_t k = 0; k < sections[s].formulas.size(); ++k) {
      const PrintedFormula& formula = sections[s].formulas[k];
      texts[text_key(s, k, formula.label)] = formula.text;
    }
  return texts;
}

std::string text_key(std::size_t s, std::size_t k, const std::string& label) {
  return label.empty() ? std::to_string(s) + "." + std::to_string(k) : label;
}

std::string latex_label(const std::string& label) {
  const std::size_t digit = label.find_first_of("0123456789");
  if (digit == 0 || digit == std::string::npos || label.find('^') != std::string::npos) {
    const bool square = label.ends_with("^2");
    const std::string name = square ? label.substr(0, label.size() - 2) : label;
    const std::string text = name == "Delta" ? "\\Delta" : latex_name(name);
    return square ? "{" + text + "}^{2}" : text;
  }
  std::string indices = label.substr(digit);
  for (char& c : indices)
    if (c == '_') c = ',';
  return latex_head(label.substr(0, digit)) + "_{" + indices + "}";
}

}  // namespace balance::formulas
