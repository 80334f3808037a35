#pragma once
/// All formulas of a mechanism with their names, by section.

#include "balance/synthesis/conditions/chosen_speeds.hpp"
#include "balance/synthesis/formulas/formula_printer.hpp"
#include "balance/synthesis/formulas/natural_formulas.hpp"
#include "balance/synthesis/formulas/reduced_equations.hpp"
#include "balance/synthesis/formulas/sheet_formula.hpp"
#include "balance/synthesis/formulas/solve_request.hpp"
#include "balance/synthesis/formulas/speed_formulas.hpp"
#include "balance/synthesis/formulas/symbolic_equations.hpp"

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace balance::formulas {

enum class SheetSectionKind {
  inertia,
  velocity,
  gravity,
  closures,
  solved,
  conditions,
  regressor,
  natural,
  efforts,    ///< without the closures
  solutions,  ///< conditions solved for named numbers
  balanced,   ///< the equations of motion with these
  reduced,    ///< the equations of motion in the independent coordinates
  speeds,     ///< the equations of motion in chosen speeds
};

/// "inertia", …, in the enum's order.
const std::vector<std::string>& sheet_section_names();

struct SheetSection {
  SheetSectionKind section = SheetSectionKind::inertia;
  std::string heading;
  std::vector<SheetFormula> formulas;
  std::vector<std::string> zero;  ///< labels of formulas that vanish
  std::size_t terms = 0;
  bool is_too_long = false;                     ///< its formulas were not derived
  std::vector<std::size_t> used_sections = {};  ///< indices of earlier ones that define symbols of its formulas

  /// Counts the terms; a formula that vanishes becomes a label in `zero`.
  void add(SheetFormula formula);
};

/// Owns the ring of its formulas.
struct FormulaSheet {
  std::unique_ptr<Ring> ring;
  SymbolicEquations equations;
  std::vector<SheetSection> sections;
  std::optional<SymbolicRegressor> regressor;         ///< if requested
  std::optional<NaturalEquations> natural;            ///< if requested
  std::optional<SolvedConditions> solution;           ///< if requested
  std::optional<SpeedFormulas> speeds;                ///< if requested
  conditions::ChosenSpeeds chosen_speeds;             ///< the speeds of `speeds`
  std::optional<ReducedEquations> reduced;            ///< if requested, or needed for speeds, of a mechanism with loops
  std::vector<int> independent;                       ///< with loops: columns that determine the motion; may be empty
  std::vector<std::pair<Polynomial, double>> pivots;  ///< divisors in steps, with their usual sizes
  std::vector<std::string> notes;
};

/// The conditions of one goal, as `balance conditions` derives them.
struct GoalConditions {
  Goal goal;
  Conditions conditions;
  conditions::ConditionNames names;
  std::string reason;  ///< why there are none; else empty
};

struct SheetOptions {
  /// Empty: all sections that the mechanism has, except the regressor, natural coordinates and efforts; with numbers to
  /// solve for, `solutions` and `balanced`. With the regressor, all formulas are written in inertial parameters about
  /// the bodies' origins.
  std::vector<SheetSectionKind> only;
  ParameterExpressions expressions = ParameterExpressions::symbols;
  std::optional<SolveRequest> solve = {};
  std::vector<std::string> independent = {};  ///< names of coordinates; empty: a choice
  /// Conditions that are not coefficients of the formulas: of mechanisms with loops or constraints on speeds, and of
  /// forms of goals.
  std::vector<GoalConditions> conditions = {};
  std::vector<model::GeneralisedSpeed> speeds = {};  ///< of the section `speeds`
};

/// @throws FormulaError for anything that has no formula
FormulaSheet make_sheet(const Mechanism& mechanism, const study::SpecNumberTexts& texts,
                        const SheetOptions& options = {});

/// The formulas of a sheet as text.
struct PrintedFormula {
  std::string label;                 ///< `D12`; empty: a condition
  std::string text;                  ///< right-hand side; of a condition, the expression that must vanish
  std::optional<double> value = {};  ///< of solutions and the conditions that remain, with the spec's numbers
};

/// A number that the conditions are not solved for.
struct UnsolvedNumber {
  std::string name, reason;
};

struct PrintedSection {
  SheetSectionKind section = SheetSectionKind::inertia;
  std::string heading;
  std::vector<PrintedFormula> formulas;
  std::vector<std::string> zero;  ///< labels of formulas that vanish
  std::size_t terms = 0;
  bool is_left_out = false;                   ///< it has too many terms, or uses names of a section that has
  std::string used_left_out = {};             ///< the first section of the latter kind, `velocity`; else empty
  std::vector<std::string> nonzero = {};      ///< of solutions: what must not vanish
  std::vector<UnsolvedNumber> unsolved = {};  ///< of solutions
};

struct PrintOptions {
  PrintStyle style = PrintStyle::text;
  bool with_values = false;         ///< the spec's numbers instead of symbols
  std::vector<int> collected = {};  ///< symbols by whose powers sums are grouped
  std::size_t max_terms = 1000;     ///< per section; longer sections are left out
};

std::vector<PrintedSection> print_sheet(const FormulaSheet& sheet, const PrintOptions& options = {});

/// Key of the k-th formula of the s-th section: its label or, for a condition, which has none, and for what belongs to a
/// solution, whose labels are those of others, its position.
std::string text_key(std::size_t s, std::size_t k, SheetSectionKind section, const std::string& label);

/// Texts by text_key, for check_against_engine.
std::map<std::string, std::string> texts_by_label(const std::vector<PrintedSection>& sections);

/// `D_{12}`, `{L_{s}}^{2}`.
std::string latex_label(const std::string& label);

}  // namespace balance::formulas
