#pragma once
/// All formulas of a mechanism under their names, section by section.

#include "balance/synthesis/formulas/formula_printer.hpp"
#include "balance/synthesis/formulas/natural_formulas.hpp"
#include "balance/synthesis/formulas/symbolic_equations.hpp"

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace balance::formulas {

enum class SheetSectionKind { inertia, velocity, gravity, closures, solved, conditions, regressor, natural };

/// "inertia", …, in that order.
const std::vector<std::string>& sheet_section_names();

/// name = value, or value / denominator, or value = 0 where the name is empty.
struct SheetFormula {
  std::string name;     ///< `D`, `C`, …; empty: a condition
  std::string indices;  ///< `12`, or `1_10` where there are more than nine
  Polynomial value;
  Polynomial denominator = 1;
  std::string denominator_name;  ///< of one that has a formula of its own

  std::string label() const { return name + indices; }
};

struct SheetSection {
  SheetSectionKind section = SheetSectionKind::inertia;
  std::string heading;
  std::vector<SheetFormula> formulas;
  std::vector<std::string> zero;  ///< labels of those that vanish
  std::size_t terms = 0;
  bool is_too_long = false;  ///< it was not even made
};

/// Owns the ring that its formulas are in.
struct FormulaSheet {
  std::unique_ptr<Ring> ring;
  SymbolicEquations equations;
  std::vector<SheetSection> sections;
  std::optional<SymbolicRegressor> regressor;  ///< where it is wanted
  std::optional<NaturalEquations> natural;     ///< where they are wanted
  std::vector<std::string> notes;
};

struct SheetOptions {
  /// Empty: all that the mechanism has but for the regressor and natural coordinates. With the regressor everything is written in inertial
  /// parameters about the bodies' origins.
  std::vector<SheetSectionKind> only;
  ParameterExpressions expressions = ParameterExpressions::symbols;
};

/// @throws FormulaError for what has no formula
FormulaSheet make_sheet(const Mechanism& mechanism, const SpecNumberTexts& texts, const SheetOptions& options = {});

/// `12`, `1_10`.
std::string index_text(std::initializer_list<std::size_t> indices, std::size_t count);

/// The formulas of a sheet as text.
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
