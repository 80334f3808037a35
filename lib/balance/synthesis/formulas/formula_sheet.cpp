#include "balance/synthesis/formulas/formula_sheet.hpp"

#include "balance/mechanics/dynamics/inverse_dynamics.hpp"
#include "balance/synthesis/formulas/closure_solution.hpp"
#include "balance/synthesis/formulas/mechanism_symbols.hpp"
#include "balance/synthesis/formulas/reduced_equations.hpp"
#include "balance/synthesis/formulas/solved_conditions.hpp"
#include "balance/synthesis/formulas/speeds_section.hpp"
#include "balance/synthesis/formulas/symbolic_conditions.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <set>
#include <stdexcept>

namespace balance::formulas {

namespace {

std::string text_of(const SheetFormula& formula, FormulaPrinter& printer, const PrintOptions& options);

/// value + numerator factor/denominator + …
std::string sum_text(const SheetFormula& formula, FormulaPrinter& printer, const PrintOptions& options) {
  const bool latex = options.style == PrintStyle::latex;
  const std::string open = latex ? "\\left(" : "(", close = latex ? "\\right)" : ")";
  std::string text;
  if (!formula.value.is_zero())
    text = text_of({formula.name, formula.indices, formula.value, formula.denominator, formula.denominator_name},
                   printer, options);
  for (const FormulaProduct& product : formula.products) {
    std::string one = options.with_values
                          ? open + text_of({"", "", product.numerator, product.denominator, ""}, printer, options) +
                                close + " " + open + printer.print_numbers(product.factor) + close
                          : printer.print_product(product.numerator, product.denominator, product.factor);
    const bool negative = one.starts_with('-');
    text += text.empty() ? (negative ? "-" : "") : (negative ? " - " : " + ");
    text += one.substr(negative ? 1 : 0);
  }
  return text.empty() ? "0" : text;
}

std::string text_of(const SheetFormula& formula, FormulaPrinter& printer, const PrintOptions& options) {
  if (!formula.products.empty()) return sum_text(formula, printer, options);
  const bool latex = options.style == PrintStyle::latex;
  const std::string denominator_name = latex ? latex_name(formula.denominator_name) : formula.denominator_name;
  if (options.with_values) {
    const std::string numerator = printer.print_numbers(formula.value);
    if (formula.denominator == Polynomial(1)) return numerator;
    const std::string denominator =
        formula.denominator_name.empty() ? printer.print_numbers(formula.denominator) : denominator_name;
    return latex ? "\\frac{" + numerator + "}{" + denominator + "}" : "(" + numerator + ")/(" + denominator + ")";
  }
  if (formula.denominator == Polynomial(1)) return printer.print(formula.value);
  if (formula.denominator_name.empty()) return printer.print_ratio(formula.value, formula.denominator);
  const std::string numerator = printer.print(formula.value);
  if (latex) return "\\frac{" + numerator + "}{" + denominator_name + "}";
  return (formula.value.size() > 1 ? "(" + numerator + ")" : numerator) + "/" + denominator_name;
}

/// The value with the spec's numbers; std::nullopt where a denominator vanishes.
std::optional<double> value_of(const SheetFormula& formula) {
  const double value = evaluate_polynomial(formula.value) / evaluate_polynomial(formula.denominator);
  return std::isfinite(value) ? std::optional(value) : std::nullopt;
}

std::string reason_text(UnsolvedReason reason) {
  switch (reason) {
    case UnsolvedReason::absent: return "occurs in none of the conditions";
    case UnsolvedReason::undetermined: return "stays free: the conditions determine only the other numbers";
    case UnsolvedReason::vanishing_slope:
      return "is not solved for: what multiplies it is zero with the spec's numbers";
    case UnsolvedReason::nonlinear: return "is not solved for: no condition that remains is linear in it";
  }
  return "";
}

void add_solution_details(const FormulaSheet& sheet, FormulaPrinter& printer, const SheetSection& source,
                          PrintedSection& printed) {
  const ConditionSolution& solution = sheet.solution->solution;
  for (std::size_t k = 0; k < printed.formulas.size(); ++k) printed.formulas[k].value = value_of(source.formulas[k]);
  for (const Polynomial& factor : solution.nonzero) printed.nonzero.push_back(printer.print(factor));
  for (const UnsolvedUnknown& one : solution.unsolved)
    printed.unsolved.push_back({sheet.ring->symbol(one.symbol).name, reason_text(one.reason)});
}

}  // namespace

void SheetSection::add(SheetFormula formula) {
  terms += formula.value.size();
  for (const FormulaProduct& product : formula.products) terms += product.numerator.size() + product.factor.size();
  if (formula.value.is_zero() && formula.products.empty() && !formula.name.empty())
    zero.push_back(formula.label());
  else
    formulas.push_back(std::move(formula));
}

std::vector<PrintedSection> print_sheet(const FormulaSheet& sheet, const PrintOptions& options) {
  std::vector<PrintedSection> sections;
  FormulaPrinter printer(*sheet.ring, options.style, options.collected);
  for (const SheetSection& source : sheet.sections) {
    PrintedSection printed{source.section, source.heading, {},
                           source.zero,    source.terms,   source.is_too_long || source.terms > options.max_terms};
    for (const std::size_t used : source.used_sections)
      if (!printed.is_left_out && sections[used].is_left_out) {
        printed.is_left_out = true;
        printed.used_left_out = sheet_section_names()[static_cast<std::size_t>(sections[used].section)];
      }
    for (const SheetFormula& formula : source.formulas)
      if (!printed.is_left_out) printed.formulas.push_back({formula.label(), text_of(formula, printer, options)});
    if (source.section == SheetSectionKind::solutions) add_solution_details(sheet, printer, source, printed);
    sections.push_back(std::move(printed));
  }
  return sections;
}

std::map<std::string, std::string> texts_by_label(const std::vector<PrintedSection>& sections) {
  std::map<std::string, std::string> texts;
  for (std::size_t s = 0; s < sections.size(); ++s)
    for (std::size_t k = 0; k < sections[s].formulas.size(); ++k) {
      const PrintedFormula& formula = sections[s].formulas[k];
      texts[text_key(s, k, sections[s].section, formula.label)] = formula.text;
    }
  return texts;
}

std::string text_key(std::size_t s, std::size_t k, SheetSectionKind section, const std::string& label) {
  const bool is_of_solution = section == SheetSectionKind::solutions || section == SheetSectionKind::balanced;
  return label.empty() || is_of_solution ? std::to_string(s) + "." + std::to_string(k) : label;
}

std::string latex_label(const std::string& label) {
  if (!label.ends_with("^2")) return latex_name(label);
  return "{" + latex_name(label.substr(0, label.size() - 2)) + "}^{2}";
}

namespace {

bool is_section_requested(const SheetOptions& options, SheetSectionKind section) {
  using enum SheetSectionKind;
  const auto& only = options.only;
  const bool is_of_solution = section == solutions || section == balanced;
  if (section == speeds && only.empty()) return !options.speeds.empty() && !options.solve;
  if (only.empty()) return options.solve ? is_of_solution : !is_of_solution && section != efforts;
  return std::find(only.begin(), only.end(), section) != only.end();
}

SheetSection make_inertia_section(const SymbolicEquations& e) {
  SheetSection section{
      SheetSectionKind::inertia, "Inertia: the torque of coordinate i has D_ij times the acceleration of j", {}, {}, 0};
  const std::size_t n = e.M.size();
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = i; j < n; ++j) section.add({"D", index_text({i, j}, n), e.M[i][j]});
  return section;
}

SheetSection make_velocity_section(const SymbolicEquations& e) {
  SheetSection section{SheetSectionKind::velocity,
                       "Velocity: the torque of i has D_ijk times the rates of j and k, for both orders of j and k",
                       {},
                       {},
                       0};
  const std::size_t n = e.M.size();
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j < n; ++j)
      for (std::size_t k = j; k < n; ++k) section.add({"D", index_text({i, j, k}, n), e.D[i][j][k]});
  return section;
}

SheetSection make_gravity_section(const SymbolicEquations& e) {
  const bool springs = e.tree.has_springs();
  SheetSection section{SheetSectionKind::gravity,
                       springs ? "Weight and springs: the torque of i has D_i" : "Weight: the torque of i has D_i",
                       {},
                       {},
                       0};
  for (std::size_t i = 0; i < e.z.size(); ++i) section.add({"D", index_text({i}, e.z.size()), e.z[i]});
  for (const auto& [symbol, square] : e.lengths) section.add({square.ring()->symbol(symbol).name + "^2", "", square});
  return section;
}

SheetSection make_closure_section(const SymbolicEquations& e) {
  SheetSection section{SheetSectionKind::closures,
                       "Closures of loops: h_i = 0, and their derivatives A_ij by the coordinates",
                       {},
                       {},
                       0};
  const std::size_t n = std::max(e.M.size(), e.closure.size());
  for (std::size_t i = 0; i < e.closure.size(); ++i) section.add({"h", index_text({i}, n), e.closure[i]});
  for (std::size_t i = 0; i < e.A.size(); ++i)
    for (std::size_t j = 0; j < e.A[i].size(); ++j) section.add({"A", index_text({i, j}, n), e.A[i][j]});
  return section;
}

SheetSection make_regressor_section(const SymbolicRegressor& regressor) {
  SheetSection section{SheetSectionKind::regressor,
                       "Regressor: the torque of i has Y_ip times the p-th inertial parameter; d stands before rates, "
                       "dd before accelerations",
                       {},
                       {},
                       0};
  const std::size_t n = std::max(regressor.Y.size(), regressor.parameters.size());
  for (std::size_t i = 0; i < regressor.Y.size(); ++i)
    for (std::size_t p = 0; p < regressor.parameters.size(); ++p)
      section.add({"Y", index_text({i, p}, n), regressor.Y[i][p]});
  return section;
}

SheetSection make_natural_section(const NaturalEquations& e) {
  SheetSection section{
      SheetSectionKind::natural,
      "Natural coordinates: points i and j have the block [Mre -Mim; Mim Mre] of the mass matrix, point i "
      "has [Cre -Cim; Cim Cre] of momentum; constraints Phi_i = 0, and their derivatives G_ij",
      {},
      {},
      0};
  const std::size_t p = e.points.size(), n = std::max(e.constraint.size(), e.unknowns.size());
  for (const auto& [symbol, sum] : e.aliases) section.add({sum.ring()->symbol(symbol).name, "", sum});
  for (std::size_t i = 0; i < p; ++i)
    for (std::size_t j = i; j < p; ++j) {
      section.add({"Mre", index_text({i, j}, p), e.mass[i][j].re});
      if (i != j) section.add({"Mim", index_text({i, j}, p), e.mass[i][j].im});
    }
  for (std::size_t i = 0; i < p; ++i) {
    section.add({"Cre", index_text({i}, p), e.coefficients[i].re});
    section.add({"Cim", index_text({i}, p), e.coefficients[i].im});
  }
  for (std::size_t i = 0; i < e.constraint.size(); ++i) section.add({"Phi", index_text({i}, n), e.constraint[i]});
  for (std::size_t i = 0; i < e.jacobian.size(); ++i)
    for (std::size_t j = 0; j < e.unknowns.size(); ++j) section.add({"G", index_text({i, j}, n), e.jacobian[i][j]});
  section.zero.clear();  // nearly all entries vanish
  return section;
}

void add_natural_notes(const Mechanism& mechanism, FormulaSheet& sheet) {
  std::string list;
  for (std::size_t k = 0; k < sheet.natural->points.size(); ++k)
    list += (k > 0 ? ", " : "") + std::to_string(k + 1) + " " + sheet.natural->points[k];
  sheet.notes.push_back("points: " + list + "; x and y of the first " +
                        std::to_string(sheet.natural->unknowns.size() / 2) +
                        " are the unknowns; blocks and derivatives not listed are zero");
  if (!mechanism.discs.empty()) sheet.notes.push_back("discs turn beside the points: their inertia is not in Mre");
  if (!mechanism.couplings.empty())
    sheet.notes.push_back("couplings relate angles, which points do not have: they are not among Phi");
}

/// What vanishes with a number that is zero in the spec, and is a symbol nevertheless.
void add_zero_notes(FormulaSheet& sheet) {
  constexpr std::size_t max_listed = 8;
  for (std::size_t s = 0; s < sheet.ring->symbols().size(); ++s) {
    const Symbol& symbol = sheet.ring->symbols()[s];
    if (symbol.value != 0 || symbol.kind >= SymbolKind::slide) continue;
    std::vector<std::string> vanishing, shorter;
    for (const SheetSection& section : sheet.sections)
      for (const SheetFormula& formula : section.formulas) {
        const auto& terms = formula.value.terms();
        const auto vanishes = [s](const Term& term) { return term.monomial.exponent_of(static_cast<int>(s)) > 0; };
        const auto count = static_cast<std::size_t>(std::count_if(terms.begin(), terms.end(), vanishes));
        if (count == 0 || formula.name.empty()) continue;
        (count == terms.size() && formula.products.empty() ? vanishing : shorter).push_back(formula.label());
      }
    if (vanishing.empty() && shorter.empty()) continue;
    const auto list = [](const std::vector<std::string>& labels) {
      std::string text;
      for (std::size_t k = 0; k < labels.size() && k < max_listed; ++k) text += (k > 0 ? ", " : "") + labels[k];
      if (labels.size() > max_listed) text += " and " + std::to_string(labels.size() - max_listed) + " more";
      return text;
    };
    sheet.notes.push_back(symbol.name + " is 0 in the spec: " +
                          (vanishing.empty() ? "" : list(vanishing) + " vanish" + (vanishing.size() == 1 ? "es" : "")) +
                          (vanishing.empty() || shorter.empty() ? "" : ", and ") +
                          (shorter.empty() ? "" : "terms of " + list(shorter) + (vanishing.empty() ? " vanish" : "")) +
                          " with it");
  }
}

/// `l cos(theta2)`, `W3`: each product once, without its number. @param divisors single terms
std::vector<std::string> list_divisors(const FormulaSheet& sheet, const std::vector<Polynomial>& divisors) {
  FormulaPrinter printer(*sheet.ring);
  std::vector<std::string> list;
  for (const Polynomial& divisor : divisors) {
    Term term = divisor.terms()[0];
    if (term.monomial.is_one() && term.wave == 0) continue;
    term.coefficient = 1;
    std::string text = printer.print(Polynomial::of_terms(sheet.ring.get(), {term}));
    if (std::find(list.begin(), list.end(), text) == list.end()) list.push_back(std::move(text));
  }
  return list;
}

/// What depends on the pose: slides, angles that are not fixed, lengths of springs, and what is defined by these.
class PoseDependence {
 public:
  /// @param definitions in their order
  PoseDependence(const SymbolicEquations& equations, const std::vector<SheetFormula>& definitions) {
    for (const auto& [symbol, square] : equations.lengths) symbols_.insert(symbol);
    for (const SheetFormula& formula : definitions)
      if (depends(formula)) symbols_.insert(formula.symbol);
  }

  bool depends(const Polynomial& p) const {
    return std::any_of(p.terms().begin(), p.terms().end(), [&](const Term& term) {
      return depends(*p.ring(), term.monomial) || moves(*p.ring(), term.wave);
    });
  }

 private:
  bool depends(const SheetFormula& formula) const {
    return depends(formula.value) || depends(formula.denominator) ||
           std::any_of(formula.products.begin(), formula.products.end(), [&](const FormulaProduct& product) {
             return depends(product.numerator) || depends(product.denominator) || depends(product.factor);
           });
  }
  bool depends(const Ring& ring, const Monomial& monomial) const {
    for (int k = 0; k < monomial.size(); ++k)
      if (ring.symbol(monomial.symbol(k)).kind == SymbolKind::slide || symbols_.contains(monomial.symbol(k)))
        return true;
    return false;
  }
  static bool moves(const Ring& ring, TrigonometricId wave) {
    if (wave == 0) return false;
    const TrigonometricMonomial& functions = ring.wave(wave);
    return std::any_of(functions.begin(), functions.end(), [&](const CircularFunction& function) {
      return std::any_of(function.argument.begin(), function.argument.end(),
                         [&](const auto& multiple) { return !ring.angle(multiple.first).is_fixed; });
    });
  }

  std::set<int> symbols_;
};

/// Names the divisors of the speeds that vanish at some poses.
void add_speeds_note(FormulaSheet& sheet) {
  const PoseDependence pose(sheet.equations, sheet.speeds->definitions);
  std::vector<Polynomial> divisors;
  for (const Polynomial& divisor : sheet.speeds->divisors)
    if (pose.depends(divisor)) divisors.push_back(divisor);
  if (const std::vector<std::string> list = list_divisors(sheet, divisors); !list.empty())
    sheet.notes.push_back(fmt::format("where {} {}, the speeds do not determine the motion", fmt::join(list, ", "),
                                      list.size() > 1 ? "vanish" : "vanishes"));
}

void add_notes(const Mechanism& mechanism, FormulaSheet& sheet) {
  if (sheet.natural) add_natural_notes(mechanism, sheet);
  if (sheet.regressor)
    sheet.notes.push_back("inertial parameters, about the bodies' origins: " +
                          parameter_text(*sheet.ring, *sheet.regressor));
  const SymbolicTree& tree = sheet.equations.tree;
  std::vector<Polynomial> pivots;
  for (const auto& [pivot, size] : sheet.pivots) pivots.push_back(pivot);
  if (const std::vector<std::string> divisors = list_divisors(sheet, pivots); !divisors.empty())
    sheet.notes.push_back(fmt::format(
        "the steps divide by {}, which must not vanish, although the mechanism may be regular where they do",
        fmt::join(divisors, ", ")));
  if (sheet.speeds) add_speeds_note(sheet);
  if (sheet.solution && !sheet.solution->unnamed.empty())
    sheet.notes.push_back(
        "c1, …, coefficients without a formula, are numbers of this geometry: the solution holds for the spec's "
        "lengths");
  if (!tree.excluded_terms.empty())
    sheet.notes.push_back(fmt::format("left out of these formulas, which are functions of the pose: {}",
                                      fmt::join(tree.excluded_terms, ", ")));
  if (has_velocity_constraints(mechanism))
    sheet.notes.push_back("these are the equations of all coordinates, without the constraints on speeds");
  if (!mechanism.couplings.empty()) sheet.notes.push_back("coordinates that follow others move along with them");
  for (const AngleRelation& relation : tree.relations) {
    std::string sum;
    for (const auto& [angle, multiple] : relation.multiples) {
      sum += sum.empty() ? (multiple < 0 ? "-" : "") : (multiple < 0 ? " - " : " + ");
      sum += (std::abs(multiple) == 1 ? "" : std::to_string(std::abs(multiple)) + " ") + sheet.ring->angle(angle).name;
    }
    sheet.notes.push_back(sheet.ring->angle(relation.angle).name + " = " + sum + ", up to whole turns");
  }
  add_zero_notes(sheet);
}

}  // namespace

const std::vector<std::string>& sheet_section_names() {
  static const std::vector<std::string> names{"inertia",    "velocity",  "gravity", "closures", "solved",
                                              "conditions", "regressor", "natural", "efforts",  "solutions",
                                              "balanced",   "reduced",   "speeds"};
  return names;
}

namespace {

/// Larger mechanisms' equations in the independent coordinates are not derived.
constexpr std::size_t max_reduced_terms = 40'000;

bool has_requested_elimination(const SymbolicEquations& e, const SheetOptions& options) {
  using enum SheetSectionKind;
  const bool has_solved = is_section_requested(options, solved) && (!e.closure.empty() || !e.tree.discs.empty());
  return has_solved || is_section_requested(options, efforts) ||
         ((is_section_requested(options, reduced) || is_section_requested(options, speeds)) && !e.closure.empty());
}

/// `phi_d5 = beta theta3`.
void add_disc_notes(FormulaSheet& sheet) {
  FormulaPrinter printer(*sheet.ring, PrintStyle::text);
  for (const DiscFrame& disc : sheet.equations.tree.discs) {
    const JointVariable& variable = sheet.equations.tree.variables[static_cast<std::size_t>(disc.variable)];
    std::string sum;
    for (const auto& [column, ratio] : variable.follows) {
      const std::string& name = sheet.equations.tree.columns[static_cast<std::size_t>(column)];
      const std::string factor = ratio == Polynomial(1) ? "" : printer.print(ratio) + " ";
      sum += (sum.empty() ? "" : " + ") + (ratio.size() > 1 ? "(" + printer.print(ratio) + ") " : factor) + name;
    }
    if (!variable.offset.is_zero()) sum += " + " + printer.print(variable.offset);
    sheet.notes.push_back(sheet.ring->angle(variable.index).name + " = " + sum);
  }
}

/// A note says why if the closures are not solved.
std::unique_ptr<ClosureElimination> eliminate_closures(const Mechanism& mechanism, const SheetOptions& options,
                                                       FormulaSheet& sheet) {
  try {
    return std::make_unique<ClosureElimination>(
        *sheet.ring, sheet.equations,
        choose_independent_columns(*sheet.ring, mechanism, sheet.equations, options.independent));
  } catch (const FormulaError& error) {
    if (!options.only.empty() || !options.independent.empty()) throw;
    sheet.notes.push_back(std::string("the closures are not solved for rates: ") + error.what());
    return nullptr;
  }
}

/// Columns of the tree that determine the motion, in which the engine, with which the equations are compared, has
/// results; empty if there are none. On its own, the engine might take coordinates of joints that are cut.
std::vector<int> choose_engine_columns(const Mechanism& mechanism, const SheetOptions& options,
                                       const FormulaSheet& sheet, const ClosureElimination* elimination) {
  try {
    const std::vector<int> columns =
        elimination != nullptr
            ? elimination->independent()
            : choose_independent_columns(*sheet.ring, mechanism, sheet.equations, options.independent).independent;
    InverseOptions engine_options;
    engine_options.independent = coordinate_names(mechanism, sheet.equations.tree, columns);
    const InverseDynamics engine(without_speed_constraints(mechanism), engine_options);
    return columns;
  } catch (const IndependentCoordinatesError&) {
    throw;
  } catch (const FormulaError&) {
  } catch (const std::invalid_argument&) {
  }
  return {};
}

/// The equations in the independent coordinates, which those in speeds use, too. Without them, there is an empty section
/// that is too long, or a note.
void add_independent_equations(const SheetOptions& options, FormulaSheet& sheet, ClosureElimination& elimination) {
  const std::string names = independent_names(sheet.equations, elimination.independent());
  std::vector<SheetSectionKind> requested;
  for (const SheetSectionKind kind : {SheetSectionKind::reduced, SheetSectionKind::speeds})
    if (is_section_requested(options, kind)) requested.push_back(kind);
  const std::size_t terms = estimate_reduced_terms(sheet.equations, elimination.independent().size());
  const auto leave_out = [&] {
    for (const SheetSectionKind kind : requested) {
      const std::string of =
          kind == SheetSectionKind::speeds ? "Efforts at the speeds, from the torques of " : "Torques of ";
      sheet.sections.push_back({kind, of + names + " in the independent coordinates", {}, {}, terms, true});
    }
  };
  if (terms > max_reduced_terms) return leave_out();
  if (sheet.independent.empty()) {
    for (const SheetSectionKind kind : requested)
      sheet.notes.push_back("no " + sheet_section_names()[static_cast<std::size_t>(kind)] +
                            (names.empty() ? ": the mechanism cannot move"
                                           : ": there is no numerical result in " + names + " to check it with"));
    return;
  }
  try {
    sheet.reduced = derive_reduced_equations(*sheet.ring, sheet.equations, elimination);
  } catch (const FormulaError&) {
    if (!options.only.empty()) throw;
    leave_out();
  }
}

/// Sections of conditions, or notes why there are none.
void add_conditions(const Mechanism& mechanism, const SheetOptions& options, FormulaSheet& sheet) {
  const SymbolicEquations& e = sheet.equations;
  if (e.closure.empty() && !has_velocity_constraints(mechanism))
    for (SheetSection& section : make_condition_sections(e)) sheet.sections.push_back(std::move(section));
  bool has_numbers = false;
  for (const GoalConditions& one : options.conditions) {
    const std::string goal = study::goal_name(one.goal);
    if (!one.reason.empty()) {
      sheet.notes.push_back("no conditions for the goal " + goal + ": " + one.reason);
      continue;
    }
    try {
      ConvertedConditions converted = convert_conditions(*sheet.ring, e.tree, one.conditions, one.names);
      SheetSection section{SheetSectionKind::conditions, "Conditions for the goal " + goal, {}, {}, 0};
      for (Polynomial& row : converted.conditions) section.add({"", "", std::move(row)});
      sheet.sections.push_back(std::move(section));
      has_numbers = has_numbers || !converted.unnamed.empty();
    } catch (const FormulaError& error) {
      sheet.notes.push_back("no formulas of the conditions for the goal " + goal + ": " + error.what() +
                            "; balance conditions prints them");
    }
  }
  if (has_numbers) sheet.notes.push_back("c1, …, coefficients without a formula, are numbers of this geometry");
}

/// Index of the first section of a kind.
std::optional<std::size_t> find_section(const FormulaSheet& sheet, SheetSectionKind kind) {
  const auto found = std::find_if(sheet.sections.begin(), sheet.sections.end(),
                                  [kind](const SheetSection& section) { return section.section == kind; });
  if (found == sheet.sections.end()) return std::nullopt;
  return static_cast<std::size_t>(found - sheet.sections.begin());
}

std::vector<std::string> names_of_unknown_parameters(const SolveRequest& request) {
  std::vector<std::string> names;
  for (const UnknownNumber& unknown : request.unknowns)
    if (!unknown.parameter.empty()) names.push_back(unknown.parameter);
  return names;
}

/// `xg1 is bodies.crank.com[0]`, for what has another name in the formulas than in the request.
void add_solved_name_note(FormulaSheet& sheet) {
  std::string list;
  for (std::size_t k = 0; k < sheet.solution->unknowns.size(); ++k) {
    const UnknownNumber& unknown = sheet.solution->unknowns[k];
    const std::string& name = sheet.ring->symbol(sheet.solution->symbols[k]).name;
    if (name == unknown.name) continue;
    list += (list.empty() ? "" : ", ") + name + " is " + (unknown.path.empty() ? unknown.parameter : unknown.path);
  }
  if (!list.empty()) sheet.notes.push_back(list);
}

/// Says why sections that were named are missing.
void add_missing_notes(const SheetOptions& options, FormulaSheet& sheet) {
  for (const SheetSectionKind kind : options.only) {
    using enum SheetSectionKind;
    if (find_section(sheet, kind) || kind == solutions || kind == conditions) continue;
    const std::string name = sheet_section_names()[static_cast<std::size_t>(kind)];
    if (sheet.equations.closure.empty() && (kind == closures || kind == solved || kind == reduced))
      sheet.notes.push_back("no " + name + ": the mechanism has no loops" +
                            (kind == reduced ? "; inertia, velocity and gravity are in independent coordinates" : ""));
    if (!sheet.equations.closure.empty() && kind == balanced)
      sheet.notes.push_back("no balanced equations of a mechanism with loops; efforts has its torques");
  }
}

}  // namespace

FormulaSheet make_sheet(const Mechanism& spec_mechanism, const study::SpecNumberTexts& texts,
                        const SheetOptions& options) {
  const Mechanism mechanism = attach_payloads(spec_mechanism);
  FormulaSheet sheet;
  sheet.ring = std::make_unique<Ring>();
  const bool has_regressor =
      std::find(options.only.begin(), options.only.end(), SheetSectionKind::regressor) != options.only.end();
  const bool has_natural =
      std::find(options.only.begin(), options.only.end(), SheetSectionKind::natural) != options.only.end();
  const TreeOptions tree{has_regressor ? InertialParametrisation::about_origin : InertialParametrisation::about_com,
                         options.expressions, has_natural, find_coordinates(mechanism, options.independent),
                         options.solve ? list_dependent_parameters(texts, names_of_unknown_parameters(*options.solve))
                                       : std::set<std::string>()};
  sheet.equations = derive_equations(*sheet.ring, build_symbolic_tree(*sheet.ring, mechanism, texts, tree));
  const SymbolicEquations& e = sheet.equations;
  if (e.closure.empty()) check_independent_without_loops(mechanism, e.tree, options.independent);
  const auto add = [&](SheetSectionKind section, auto&& build) {
    if (!is_section_requested(options, section)) return;
    SheetSection result = build();
    if (!result.formulas.empty() || !result.zero.empty() || section == SheetSectionKind::solutions)
      sheet.sections.push_back(std::move(result));
  };
  add(SheetSectionKind::inertia, [&] { return make_inertia_section(e); });
  add(SheetSectionKind::velocity, [&] { return make_velocity_section(e); });
  add(SheetSectionKind::gravity, [&] { return make_gravity_section(e); });
  if (!e.closure.empty()) add(SheetSectionKind::closures, [&] { return make_closure_section(e); });
  const bool needs_elimination = has_requested_elimination(e, options);
  std::unique_ptr<ClosureElimination> elimination;
  if (needs_elimination) elimination = eliminate_closures(mechanism, options, sheet);
  if (!e.closure.empty()) sheet.independent = choose_engine_columns(mechanism, options, sheet, elimination.get());
  if (elimination) {
    const bool has_rows = !e.closure.empty() || (!e.tree.discs.empty() && !options.only.empty());
    if (has_rows) add(SheetSectionKind::solved, [&] { return make_solved_section(*sheet.ring, e, *elimination); });
  }
  if (is_section_requested(options, SheetSectionKind::conditions)) add_conditions(mechanism, options, sheet);
  if (has_regressor) {
    sheet.regressor = derive_regressor(*sheet.ring, e);
    add(SheetSectionKind::regressor, [&] { return make_regressor_section(*sheet.regressor); });
  }
  if (has_natural) {
    sheet.natural = derive_natural_equations(*sheet.ring, *e.tree.basic_points);
    add(SheetSectionKind::natural, [&] { return make_natural_section(*sheet.natural); });
  }
  if (options.solve) {
    sheet.solution = solve_balance_conditions(*sheet.ring, mechanism, e, *options.solve);
    add(SheetSectionKind::solutions, [&] { return make_solution_section(*sheet.ring, *sheet.solution); });
    add_solved_name_note(sheet);
    if (e.closure.empty()) add(SheetSectionKind::balanced, [&] { return make_balanced_section(e, *sheet.solution); });
  }
  if (elimination) {
    add(SheetSectionKind::efforts,
        [&] { return make_effort_section(*sheet.ring, e, *elimination, sheet.solution ? &*sheet.solution : nullptr); });
    const bool has_independent_equations = is_section_requested(options, SheetSectionKind::reduced) ||
                                           is_section_requested(options, SheetSectionKind::speeds);
    if (!e.closure.empty() && has_independent_equations) add_independent_equations(options, sheet, *elimination);
    if (sheet.reduced)
      add(SheetSectionKind::reduced,
          [&] { return make_reduced_section(e, *sheet.reduced, find_section(sheet, SheetSectionKind::solved)); });
    for (const EliminationPivot& pivot : elimination->pivots()) sheet.pivots.emplace_back(pivot.value, pivot.size);
  }
  if (find_section(sheet, SheetSectionKind::solved) && !e.tree.is_planar) add_disc_notes(sheet);
  if (is_section_requested(options, SheetSectionKind::speeds) && (e.closure.empty() || sheet.reduced)) {
    sheet.chosen_speeds = conditions::ChosenSpeeds(mechanism, options.speeds);
    sheet.speeds = derive_speed_formulas(*sheet.ring, e, options.speeds, sheet.reduced ? &*sheet.reduced : nullptr);
    add(SheetSectionKind::speeds, [&] { return make_speeds_section(sheet); });
  }
  add_notes(mechanism, sheet);
  add_missing_notes(options, sheet);
  return sheet;
}

}  // namespace balance::formulas
