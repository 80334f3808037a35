#include "balance/synthesis/formulas/formula_sheet.hpp"

#include <algorithm>
#include <cstdlib>

namespace balance::formulas {

// Conditions for a mechanism without loops to be balanced, with symbols for its lengths.

/// Rows that must vanish for polynomials to vanish at every pose: the coefficients of all waves, without common lengths
/// and without duplicates. Combinations of shorter rows are removed as far as they are recognised.
std::vector<Polynomial> extract_conditions(const std::vector<Polynomial>& entries);

/// One section per goal: static, force, gyroscopic, decoupled.
std::vector<SheetSection> make_condition_sections(const SymbolicEquations& equations);

// Loop closures, solved for the rates of some coordinates.

/// Larger systems are not solved: the determinant becomes longer than the closures.
inline constexpr std::size_t max_solved_closures = 4;

/// q̇ of dependent columns = C · q̇ of independent ones, by Cramer's rule; the determinant has the first formula. Empty
/// if there are more than max_solved_closures equations, or if their number is not that of the dependent columns.
/// @param independent columns
std::vector<SheetFormula> solve_closures(const SymbolicEquations& equations, const std::vector<int>& independent);

/// Replaces sums of angles around a loop by the angle of the joint that closes it, if that is shorter.
Polynomial shorten_angle_sums(const SymbolicTree& tree, const Polynomial& p);

namespace {

/// Longer lists are not searched for combinations, since the search takes quadratic time.
constexpr std::size_t max_compared_rows = 300;

/// Equations with more terms have no readable conditions.
constexpr std::size_t max_condition_terms = 6000;

/// The powers of lengths and gravity that all terms share. Coordinates of slides are functions of the pose instead.
Monomial common_lengths(const Polynomial& p) {
  Monomial common = p.terms()[0].monomial.select([&](int s, int) {
    const auto kind = p.ring()->symbol(s).kind;
    return kind == SymbolKind::length || kind == SymbolKind::gravity;
  });
  for (const Term& term : p.terms()) {
    Monomial shared;
    for (int k = 0; k < common.size(); ++k)
      shared.append(common.symbol(k), std::min(common.exponent(k), term.monomial.exponent_of(common.symbol(k))));
    common = shared;
  }
  return common;
}

/// Coefficients of all functions of the pose: waves times powers of slides' coordinates.
std::vector<Polynomial> coefficients(const Polynomial& p) {
  std::map<std::pair<TrigonometricId, Monomial>, std::vector<Term>> groups;
  for (const Term& term : p.terms()) {
    const auto is_pose = [&](int s) {
      const auto kind = p.ring()->symbol(s).kind;
      return kind == SymbolKind::slide || kind == SymbolKind::alias;
    };
    const Monomial pose = term.monomial.select([&](int s, int) { return is_pose(s); });
    groups[{term.wave, pose}].push_back({term.monomial / pose, 0, term.coefficient});
  }
  std::vector<Polynomial> list;
  for (auto& [key, terms] : groups) list.push_back(Polynomial::of_terms(p.ring(), std::move(terms)));
  return list;
}

/// Subtracts a multiple of a known row, if that makes the row shorter.
bool reduce_by_row(Polynomial& row, const Polynomial& pivot_row) {
  const Term& leading_term = pivot_row.terms()[0];
  for (const Term& term : row.terms()) {
    const Monomial ratio = term.monomial / leading_term.monomial;
    bool is_divisible = true;
    for (int k = 0; k < ratio.size(); ++k) is_divisible = is_divisible && ratio.exponent(k) > 0;
    if (!is_divisible) continue;
    const Polynomial reduced =
        row - Polynomial::of_terms(row.ring(), {{ratio, 0, term.coefficient / leading_term.coefficient}}) * pivot_row;
    if (reduced.size() >= row.size()) continue;
    row = reduced;
    return true;
  }
  return false;
}

bool is_combination_of(Polynomial row, const std::vector<Polynomial>& independent_rows) {
  for (bool has_changed = true; has_changed && !row.is_zero();) {
    has_changed = false;
    for (const Polynomial& pivot_row : independent_rows)
      if (!row.is_zero() && reduce_by_row(row, pivot_row)) has_changed = true;
  }
  return row.is_zero();
}

}  // namespace

std::vector<Polynomial> extract_conditions(const std::vector<Polynomial>& entries) {
  std::vector<Polynomial> rows;
  for (const Polynomial& entry : entries)
    for (const Polynomial& p : coefficients(entry)) {
      const Monomial common = common_lengths(p);
      const Rational leading_coefficient = p.terms()[0].coefficient;
      std::vector<Term> terms;
      for (const Term& term : p.terms())
        terms.push_back({term.monomial / common, 0, term.coefficient / leading_coefficient});
      Polynomial row = Polynomial::of_terms(p.ring(), std::move(terms));
      if (std::find(rows.begin(), rows.end(), row) == rows.end()) rows.push_back(std::move(row));
    }
  std::stable_sort(rows.begin(), rows.end(), [](auto& a, auto& b) { return a.size() < b.size(); });
  if (rows.size() > max_compared_rows) return rows;
  std::vector<Polynomial> independent_rows;
  for (const Polynomial& row : rows)
    if (!is_combination_of(row, independent_rows)) independent_rows.push_back(row);
  return independent_rows;
}

std::vector<SheetSection> make_condition_sections(const SymbolicEquations& e) {
  const std::size_t n = e.M.size();
  std::vector<Polynomial> force, gyroscopic = e.z, decoupled;
  for (const Polynomial& h : e.moment)
    for (std::size_t c = 0; c < n; ++c) force.push_back(column_derivative(e.tree, h, static_cast<int>(c)));
  for (const Matrix& rows : e.D)
    for (const Row& row : rows) gyroscopic.insert(gyroscopic.end(), row.begin(), row.end());
  decoupled = gyroscopic;
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = i + 1; j < n; ++j) decoupled.push_back(e.M[i][j]);
  std::vector<SheetSection> sections;
  const auto add = [&](const std::string& goal, const std::vector<Polynomial>& entries) {
    SheetSection section{SheetSectionKind::conditions, "Conditions for the goal " + goal, {}, {}, 0};
    for (const Polynomial& entry : entries) section.terms += entry.size();
    section.is_too_long = section.terms > max_condition_terms;
    if (!section.is_too_long) section.terms = 0;
    for (Polynomial& row : section.is_too_long ? std::vector<Polynomial>() : extract_conditions(entries)) {
      section.terms += row.size();
      section.formulas.push_back({"", "", std::move(row), Polynomial(1), ""});
    }
    sections.push_back(std::move(section));
  };
  add("static", e.z);
  add("force", force);
  add("gyroscopic", gyroscopic);
  add("decoupled", decoupled);
  return sections;
}

namespace {

std::string text_of(const SheetFormula& formula, FormulaPrinter& printer, const PrintOptions& options) {
  if (options.with_values) {
    const std::string numerator = printer.print_numbers(formula.value);
    if (formula.denominator == Polynomial(1)) return numerator;
    const std::string denominator =
        formula.denominator_name.empty() ? printer.print_numbers(formula.denominator) : formula.denominator_name;
    return options.style == PrintStyle::latex ? "\\frac{" + numerator + "}{" + denominator + "}"
                                              : "(" + numerator + ")/(" + denominator + ")";
  }
  if (formula.denominator == Polynomial(1)) return printer.print(formula.value);
  if (formula.denominator_name.empty()) return printer.print_ratio(formula.value, formula.denominator);
  const bool latex = options.style == PrintStyle::latex;
  const std::string numerator = printer.print(formula.value);
  if (latex) return "\\frac{" + numerator + "}{" + latex_name(formula.denominator_name) + "}";
  return (formula.value.size() > 1 ? "(" + numerator + ")" : numerator) + "/" + formula.denominator_name;
}

/// Blocks in natural coordinates are complex numbers.
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
  for (const SheetSection& source : sheet.sections) {
    PrintedSection printed{source.section, source.heading, {},
                           source.zero,    source.terms,   source.is_too_long || source.terms > options.max_terms};
    for (const SheetFormula& formula : source.formulas)
      if (!printed.is_left_out) printed.formulas.push_back({formula.label(), text_of(formula, printer, options)});
    sections.push_back(std::move(printed));
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
    const bool is_square = label.ends_with("^2");
    const std::string name = is_square ? label.substr(0, label.size() - 2) : label;
    const std::string text = name == "Delta" ? "\\Delta" : latex_name(name);
    return is_square ? "{" + text + "}^{2}" : text;
  }
  std::string indices = label.substr(digit);
  for (char& c : indices)
    if (c == '_') c = ',';
  return latex_head(label.substr(0, digit)) + "_{" + indices + "}";
}

namespace {

bool is_section_requested(const SheetOptions& options, SheetSectionKind section) {
  const auto& only = options.only;
  return only.empty() || std::find(only.begin(), only.end(), section) != only.end();
}

void add_formula(SheetSection& section, SheetFormula formula) {
  section.terms += formula.value.size();
  if (formula.value.is_zero() && !formula.name.empty())
    section.zero.push_back(formula.label());
  else
    section.formulas.push_back(std::move(formula));
}

SheetSection make_inertia_section(const SymbolicEquations& e) {
  SheetSection section{
      SheetSectionKind::inertia, "Inertia: the torque of coordinate i has D_ij times the acceleration of j", {}, {}, 0};
  const std::size_t n = e.M.size();
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = i; j < n; ++j) add_formula(section, {"D", index_text({i, j}, n), e.M[i][j], 1, ""});
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
      for (std::size_t k = j; k < n; ++k) add_formula(section, {"D", index_text({i, j, k}, n), e.D[i][j][k], 1, ""});
  return section;
}

SheetSection make_gravity_section(const SymbolicEquations& e) {
  const bool springs = e.tree.has_springs();
  SheetSection section{SheetSectionKind::gravity,
                       springs ? "Weight and springs: the torque of i has D_i" : "Weight: the torque of i has D_i",
                       {},
                       {},
                       0};
  for (std::size_t i = 0; i < e.z.size(); ++i) add_formula(section, {"D", index_text({i}, e.z.size()), e.z[i], 1, ""});
  for (const auto& [symbol, square] : e.lengths)
    add_formula(section, {square.ring()->symbol(symbol).name + "^2", "", square, 1, ""});
  return section;
}

SheetSection make_closure_section(const SymbolicEquations& e) {
  SheetSection section{SheetSectionKind::closures,
                       "Closures of loops: h_i = 0, and their derivatives A_ij by the coordinates",
                       {},
                       {},
                       0};
  const std::size_t n = std::max(e.M.size(), e.closure.size());
  for (std::size_t i = 0; i < e.closure.size(); ++i)
    add_formula(section, {"h", index_text({i}, n), e.closure[i], 1, ""});
  for (std::size_t i = 0; i < e.A.size(); ++i)
    for (std::size_t j = 0; j < e.A[i].size(); ++j)
      add_formula(section, {"A", index_text({i, j}, n), e.A[i][j], 1, ""});
  return section;
}

/// The actuated columns; if these are fewer than the freedoms, the first of the other columns are added.
std::vector<int> independent_columns(const Mechanism& mechanism, const SymbolicEquations& e) {
  std::vector<int> columns;
  const std::size_t freedoms = e.M.size() - std::min(e.A.size(), e.M.size());
  for (const int actuator : mechanism.actuators)
    for (std::size_t c = 0; c < e.M.size(); ++c)
      if (e.tree.coordinates[c] == actuator) columns.push_back(static_cast<int>(c));
  for (std::size_t c = 0; columns.size() < freedoms && c < e.M.size(); ++c)
    if (std::find(columns.begin(), columns.end(), static_cast<int>(c)) == columns.end())
      columns.push_back(static_cast<int>(c));
  std::sort(columns.begin(), columns.end());
  return columns;
}

SheetSection make_solved_section(const Mechanism& mechanism, const SymbolicEquations& e) {
  SheetSection section{
      SheetSectionKind::solved,
      "Closures solved: the rate of coordinate i is the sum of C_ij times the rate of the j-th independent one",
      {},
      {},
      0};
  for (SheetFormula& formula : solve_closures(e, independent_columns(mechanism, e)))
    add_formula(section, std::move(formula));
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
      add_formula(section, {"Y", index_text({i, p}, n), regressor.Y[i][p], 1, ""});
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
  for (const auto& [symbol, sum] : e.aliases) add_formula(section, {sum.ring()->symbol(symbol).name, "", sum, 1, ""});
  for (std::size_t i = 0; i < p; ++i)
    for (std::size_t j = i; j < p; ++j) {
      add_formula(section, {"Mre", index_text({i, j}, p), e.mass[i][j].re, 1, ""});
      if (i != j) add_formula(section, {"Mim", index_text({i, j}, p), e.mass[i][j].im, 1, ""});
    }
  for (std::size_t i = 0; i < p; ++i) {
    add_formula(section, {"Cre", index_text({i}, p), e.coefficients[i].re, 1, ""});
    add_formula(section, {"Cim", index_text({i}, p), e.coefficients[i].im, 1, ""});
  }
  for (std::size_t i = 0; i < e.constraint.size(); ++i)
    add_formula(section, {"Phi", index_text({i}, n), e.constraint[i], 1, ""});
  for (std::size_t i = 0; i < e.jacobian.size(); ++i)
    for (std::size_t j = 0; j < e.unknowns.size(); ++j)
      add_formula(section, {"G", index_text({i, j}, n), e.jacobian[i][j], 1, ""});
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

void add_notes(const Mechanism& mechanism, FormulaSheet& sheet) {
  if (sheet.natural) add_natural_notes(mechanism, sheet);
  if (sheet.regressor)
    sheet.notes.push_back("inertial parameters, about the bodies' origins: " +
                          parameter_text(*sheet.ring, *sheet.regressor));
  const SymbolicTree& tree = sheet.equations.tree;
  std::string excluded;
  for (const std::string& kind : tree.excluded_terms) excluded += (excluded.empty() ? "" : ", ") + kind;
  if (!excluded.empty())
    sheet.notes.push_back("left out of these formulas, which are functions of the pose: " + excluded);
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
}

}  // namespace

const std::vector<std::string>& sheet_section_names() {
  static const std::vector<std::string> names{"inertia", "velocity",   "gravity",   "closures",
                                              "solved",  "conditions", "regressor", "natural"};
  return names;
}

std::string index_text(std::initializer_list<std::size_t> indices, std::size_t count) {
  std::string text;
  for (const std::size_t index : indices) text += (count > 9 && !text.empty() ? "_" : "") + std::to_string(index + 1);
  return text;
}

FormulaSheet make_sheet(const Mechanism& mechanism, const study::SpecNumberTexts& texts, const SheetOptions& options) {
  FormulaSheet sheet;
  sheet.ring = std::make_unique<Ring>();
  const bool has_regressor =
      std::find(options.only.begin(), options.only.end(), SheetSectionKind::regressor) != options.only.end();
  const bool has_natural =
      std::find(options.only.begin(), options.only.end(), SheetSectionKind::natural) != options.only.end();
  const TreeOptions tree{has_regressor ? InertialParametrisation::about_origin : InertialParametrisation::about_com,
                         options.expressions, has_natural};
  sheet.equations = derive_equations(*sheet.ring, build_symbolic_tree(*sheet.ring, mechanism, texts, tree));
  const SymbolicEquations& e = sheet.equations;
  const auto add = [&](SheetSectionKind section, auto&& build) {
    if (!is_section_requested(options, section)) return;
    SheetSection result = build();
    if (!result.formulas.empty() || !result.zero.empty()) sheet.sections.push_back(std::move(result));
  };
  add(SheetSectionKind::inertia, [&] { return make_inertia_section(e); });
  add(SheetSectionKind::velocity, [&] { return make_velocity_section(e); });
  add(SheetSectionKind::gravity, [&] { return make_gravity_section(e); });
  if (!e.closure.empty()) {
    add(SheetSectionKind::closures, [&] { return make_closure_section(e); });
    add(SheetSectionKind::solved, [&] { return make_solved_section(mechanism, e); });
  }
  if (e.closure.empty() && !has_velocity_constraints(mechanism) &&
      is_section_requested(options, SheetSectionKind::conditions))
    for (SheetSection& section : make_condition_sections(e)) sheet.sections.push_back(std::move(section));
  if (has_regressor) {
    sheet.regressor = derive_regressor(*sheet.ring, e);
    add(SheetSectionKind::regressor, [&] { return make_regressor_section(*sheet.regressor); });
  }
  if (has_natural) {
    sheet.natural = derive_natural_equations(*sheet.ring, *e.tree.basic_points);
    add(SheetSectionKind::natural, [&] { return make_natural_section(*sheet.natural); });
  }
  add_notes(mechanism, sheet);
  return sheet;
}

namespace {

Polynomial determinant(const Matrix& A) {
  if (A.empty()) return {1};
  Polynomial sum;
  for (std::size_t j = 0; j < A.size(); ++j) {
    if (A[0][j].is_zero()) continue;
    Matrix minor;
    for (std::size_t i = 1; i < A.size(); ++i) {
      minor.emplace_back(A[i]);
      minor.back().erase(minor.back().begin() + static_cast<std::ptrdiff_t>(j));
    }
    const Polynomial product = A[0][j] * determinant(minor);
    sum = j % 2 == 0 ? sum + product : sum - product;
  }
  return sum;
}

/// Adds a multiple of a relation, which is zero, to an argument.
CircularFunction apply_relation(const CircularFunction& function, const AngleRelation& relation, int times) {
  std::map<int, int> argument(function.argument.begin(), function.argument.end());
  for (const auto& [angle, multiple] : relation.multiples) argument[angle] += times * multiple;
  argument[relation.angle] -= times;
  CircularFunction shifted{function.group, function.is_sine, {}};
  for (const auto& [angle, multiple] : argument)
    if (multiple != 0) shifted.argument.emplace_back(angle, multiple);
  return shifted;
}

int argument_length(const CircularFunction& function) {
  int length = 0;
  for (const auto& [angle, multiple] : function.argument) length += std::abs(multiple);
  return length;
}

}  // namespace

Polynomial shorten_angle_sums(const SymbolicTree& tree, const Polynomial& p) {
  std::vector<Term> terms;
  for (const Term& term : p.terms()) {
    Term best = term;
    if (term.wave != 0) {
      TrigonometricMonomial trig = p.ring()->wave(term.wave);
      for (CircularFunction& function : trig)
        for (const AngleRelation& relation : tree.relations)
          for (const int times : {-2, -1, 1, 2}) {
            if (p.ring()->angle(relation.angle).group != function.group) continue;
            const CircularFunction shifted = apply_relation(function, relation, times);
            if (argument_length(shifted) < argument_length(function)) function = shifted;
          }
      best.wave = p.ring()->canonicalise(std::move(trig), best.coefficient);
    }
    terms.push_back(best);
  }
  return Polynomial::of_terms(p.ring(), std::move(terms));
}

std::vector<SheetFormula> solve_closures(const SymbolicEquations& e, const std::vector<int>& independent) {
  const std::size_t rows = e.A.size(), columns = e.tree.columns.size();
  std::vector<std::size_t> dependent;
  for (std::size_t c = 0; c < columns; ++c)
    if (std::find(independent.begin(), independent.end(), static_cast<int>(c)) == independent.end())
      dependent.push_back(c);
  if (rows == 0 || rows > max_solved_closures || dependent.size() != rows) return {};
  /// The dependent columns, one of which is replaced by −(column of an independent one).
  const auto replace_column = [&](std::size_t replaced, std::size_t replacement) {
    Matrix B(rows);
    for (std::size_t i = 0; i < rows; ++i)
      for (std::size_t j = 0; j < rows; ++j)
        B[i].push_back(j == replaced ? -e.A[i][replacement] : e.A[i][dependent[j]]);
    return B;
  };
  const Polynomial det = shorten_angle_sums(e.tree, determinant(replace_column(rows, 0)));
  if (det.is_zero()) return {};
  std::vector<SheetFormula> solved{{"Delta", "", det, Polynomial(1), ""}};
  for (const std::size_t d : std::vector<std::size_t>(dependent)) {
    const auto replaced_index =
        static_cast<std::size_t>(std::find(dependent.begin(), dependent.end(), d) - dependent.begin());
    for (std::size_t u = 0; u < independent.size(); ++u) {
      const auto replacement = static_cast<std::size_t>(independent[u]);
      Polynomial numerator = shorten_angle_sums(e.tree, determinant(replace_column(replaced_index, replacement)));
      if (numerator.is_zero()) continue;
      const bool has_name = det.size() > 1;
      solved.push_back({"C", index_text({d, u}, columns), std::move(numerator), det, has_name ? "Delta" : ""});
    }
  }
  if (det.size() == 1) solved.erase(solved.begin());
  return solved;
}

}  // namespace balance::formulas
