#include "balance/synthesis/formulas/speeds_section.hpp"

#include <map>
#include <optional>
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

/// What the sections of a sheet define.
class DefinedNames {
 public:
  explicit DefinedNames(const FormulaSheet& sheet) {
    for (std::size_t s = 0; s < sheet.sections.size(); ++s) {
      const SheetSection& section = sheet.sections[s];
      using enum SheetSectionKind;
      const bool is_of_tree = section.section == inertia || section.section == velocity || section.section == gravity;
      for (const SheetFormula& formula : section.formulas) {
        if (formula.symbol >= 0) by_symbol_.try_emplace(formula.symbol, s);
        if (is_of_tree) by_label_.try_emplace(formula.label(), s);
      }
    }
  }

  /// Index of the section that defines the same: by its symbol or, since the tree's equations have none, by its label.
  std::optional<std::size_t> section_of(const SheetFormula& definition) const {
    if (const auto same = by_symbol_.find(definition.symbol); same != by_symbol_.end()) return same->second;
    if (const auto same = by_label_.find(definition.label()); same != by_label_.end()) return same->second;
    return std::nullopt;
  }

 private:
  std::map<int, std::size_t> by_symbol_;
  std::map<std::string, std::size_t> by_label_;
};

}  // namespace

SheetSection make_speeds_section(const FormulaSheet& sheet) {
  const SpeedFormulas& s = *sheet.speeds;
  const std::size_t n = s.independent.size(), all = std::max(n, s.names.size());
  SheetSection section{SheetSectionKind::speeds, speeds_heading(sheet), {}, {}, 0};
  const DefinedNames names(sheet);
  std::set<std::string> defined;
  std::set<std::size_t> used;
  for (const SheetFormula& definition : s.definitions) {
    defined.insert(definition.label());
    if (const std::optional<std::size_t> other = names.section_of(definition))
      used.insert(*other);
    else
      section.add(definition);
  }
  section.used_sections.assign(used.begin(), used.end());
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
