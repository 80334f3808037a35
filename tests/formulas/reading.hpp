#pragma once
/// Formulas of the configs as they are printed, read back.

#include "balance/interface/specification/read_spec.hpp"
#include "balance/synthesis/formulas/formula_check.hpp"
#include "balance/synthesis/formulas/formula_parser.hpp"
#include "balance/synthesis/formulas/formula_sheet.hpp"

#include <algorithm>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace reading {

using namespace balance;
using namespace balance::formulas;

/// A config's sheet and its texts by label.
struct Sheets {
  Study study;
  FormulaSheet sheet;
  std::vector<PrintedSection> sections;
  std::map<std::string, std::string> texts;

  /// As printed, at a pose; what is not printed vanishes.
  /// @param instead of the spec's values
  double at(const std::string& label, const std::vector<double>& q,
            const std::map<std::string, double>& instead = {}) const {
    const auto text = texts.find(label);
    if (text == texts.end()) return 0;
    auto names = evaluate_names(sheet, q);
    for (const auto& [name, value] : instead) names.at(name) = value;
    return evaluate_text(text->second, names);
  }
  bool is_zero(const std::string& label) const {
    return std::any_of(sections.begin(), sections.end(), [&](const PrintedSection& section) {
      return std::find(section.zero.begin(), section.zero.end(), label) != section.zero.end();
    });
  }
};

inline Sheets sheets(const std::string& config, const std::vector<std::pair<std::string, std::string>>& set = {},
                     const SheetOptions& options = {}, const PrintOptions& print = {}) {
  const DesignSpace space = read_design_space_file(std::string(BALANCE_CONFIGS "/") + config, {set});
  Sheets found{space.start, {}, {}, {}};
  found.sheet = make_sheet(found.study.mechanism, specification::read_spec_number_texts(space, {set}), options);
  found.sections = print_sheet(found.sheet, print);
  found.texts = texts_by_label(found.sections);
  return found;
}

}  // namespace reading
