#pragma once
/// The formulas of a sheet as text.

#include "balance/formulas/printer.hpp"
#include "balance/formulas/sheet.hpp"

#include <map>
#include <string>
#include <vector>

namespace balance::formulas {

struct PrintedFormula {
  std::string label;  ///< `D12`; empty: a condition
  std::string text;   ///< what it is equal to; of a condition what must vanish
};

struct PrintedSection {
  SheetSectionKind section = SheetSectionKind::inertia;
  std::string heading;
  std::vector<PrintedFormula> formulas;
  std::vector<std::string> zero;  ///< labels of those that vanish
  std::size_t terms = 0;
  bool is_left_out = false;  ///< it has too many terms
};

struct PrintOptions {
  PrintStyle style = PrintStyle::text;
  bool with_values = false;      ///< the spec's numbers in place of symbols
  std::size_t max_terms = 1000;  ///< of a section; what has more is left out
};

std::vector<PrintedSection> print_sheet(const FormulaSheet& sheet, const PrintOptions& options = {});

/// The k-th formula of the s-th section under its label; a condition, which has none, under its place.
std::string text_key(std::size_t s, std::size_t k, const std::string& label);

/// Texts by text_key, for check_against_engine.
std::map<std::string, std::string> texts_by_label(const std::vector<PrintedSection>& sections);

/// `D_{12}`.
std::string latex_label(const std::string& label);

}  // namespace balance::formulas
