#pragma once
/// Closed-form formulas as text, LaTeX and JSON.

#include "balance/synthesis/formulas/formula_check.hpp"
#include "balance/synthesis/formulas/formula_sheet.hpp"

#include "balance/interface/files/text_table.hpp"

#include <string>
#include <vector>

namespace balance::reports {

/// Printed formulas and their check.
struct FormulasReportData {
  std::string title;
  const formulas::FormulaSheet* sheet = nullptr;
  std::vector<formulas::PrintedSection> sections;
  formulas::FormulaCheck check;
  std::vector<std::string> warnings;  ///< of the spec
  bool is_spec_si = true;             ///< else its parameters have other units than the other numbers, which are SI
};

std::string formulas_text(const FormulasReportData& view, std::size_t width = files::default_text_width);
/// Displayed equations (amsmath) with comments; long ones have several lines.
std::string formulas_latex(const FormulasReportData& view);
std::string formulas_json(const FormulasReportData& view);

}  // namespace balance::reports
