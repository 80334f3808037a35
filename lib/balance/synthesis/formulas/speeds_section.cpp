#include "balance/synthesis/formulas/speeds_section.hpp"

#include <algorithm>
#include <set>

namespace balance::formulas {

namespace {

std::string speeds_heading(const FormulaSheet& sheet) {
  const SpeedFormulas& s = *sheet.speeds;
  std::string names, dependent;
  for (std::size_t i = 0; i < s.names.size(); ++i) {
    std::string& list = s.is_independent(i) ? names : dependent;
    list += (list.empty() ? "" : ", ") + s.names[i];
  }
  return "In the speeds " + names + ": speed i is the sum of " + s.W_name + "_ij times the rate of coordinate j" +
         (sheet.reduced ? " of " + independent_names(sheet.equations, sheet.reduced->independent) : "") +
         ", and that rate of V_ij times speed j. The effort at speed i has M_ij times the derivative of speed j, w_ijk "
         "times the speeds j and k, for both orders, and z_i" +
         (dependent.empty() ? ""
                            : "; " + dependent + " follow: " + s.C_name + "_ij times speed j, and " + s.c_name +
                                  "_ijk in their derivatives");
}

}  // namespace

SheetSection make_speeds_section(const FormulaSheet& sheet, bool with_tree) {
  const SpeedFormulas& s = *sheet.speeds;
  const std::size_t n = s.independent.size(), all = std::max(n, s.names.size());
  SheetSection section{SheetSectionKind::speeds, speeds_heading(sheet), {}, {}, 0};
  std::set<int> known;  // symbols
  for (const SheetSection& other : sheet.sections)
    for (const SheetFormula& formula : other.formulas) known.insert(formula.symbol);
  SheetSection elsewhere;
  std::set<std::string> defined;
  for (const SheetFormula& definition : s.definitions) {
    defined.insert(definition.label());
    if (known.contains(definition.symbol))
      elsewhere.add(definition);
    else if (!with_tree || definition.name != "D")
      section.add(definition);
  }
  section.terms += elsewhere.terms;  // if the other section is too long to be printed, so is this one
  const auto add = [&](const std::string& name, std::initializer_list<std::size_t> indices, const Polynomial& value,
                       std::size_t count) {
    const std::string text = index_text(indices, count);
    if (!defined.contains(name + text)) section.add({name, text, value});
  };
  for (std::size_t i = 0; i < s.W.size(); ++i)
    for (std::size_t j = 0; j < n; ++j) add(s.W_name, {i, j}, s.W[i][j], all);
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j < n; ++j) add("V", {i, j}, s.V[i][j], n);
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = i; j < n; ++j) add("M", {i, j}, s.M[i][j], n);
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j < n; ++j)
      for (std::size_t k = j; k < n; ++k) add("w", {i, j, k}, s.w[i][j][k], n);
  for (std::size_t i = 0; i < n; ++i) add("z", {i}, s.z[i], n);
  std::size_t row = 0;
  for (std::size_t i = 0; i < s.names.size(); ++i) {
    if (s.is_independent(i)) continue;
    for (std::size_t j = 0; j < n; ++j) add(s.C_name, {i, j}, s.C[row][j], all);
    for (std::size_t j = 0; j < n; ++j)
      for (std::size_t k = j; k < n; ++k) add(s.c_name, {i, j, k}, s.c[row][j][k], all);
    ++row;
  }
  return section;
}

}  // namespace balance::formulas
