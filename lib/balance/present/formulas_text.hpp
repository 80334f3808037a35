#pragma once
/// Closed formulas for people, for LaTeX and for programs.

#include "balance/formulas/check.hpp"
#include "balance/formulas/printed.hpp"

#include <string>
#include <vector>

namespace balance {

/// What has been printed and checked.
struct FormulasView {
  std::string title;
  const formulas::Sheet* sheet = nullptr;
  std::vector<formulas::PrintedSection> sections;
  formulas::Check check;
  std::vector<std::string> warnings;  ///< of the spec
};

std::string formulas_text(const FormulasView& view);
/// Equations between `\[` and `\]` (amsmath), and nothing else.
std::string formulas_latex(const FormulasView& view);
std::string formulas_json(const FormulasView& view);

}  // namespace balance
