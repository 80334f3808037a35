#include "balance/formulas/sheet.hpp"

#include "balance/formulas/balance_conditions.hpp"
#include "balance/formulas/solved_closures.hpp"

#include <algorithm>
#include <cstdlib>

namespace balance::formulas {

namespace {

bool is_wanted(const SheetOptions& options, SheetSectionKind section) {
  const auto& only = options.only;
  return only.empty() || std::find(only.begin(), only.end(), section) != only.end();
}

void add_formula(SheetSection& to, SheetFormula formula) {
  to.terms += formula.value.size();
  if (formula.value.is_zero() && !formula.name.empty())
    to.zero.push_back(formula.label());
  else
    to.formulas.push_back(std::move(formula));
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

/// The actuated columns if they are as many as is left free, else the first ones.
std::vector<int> independent_columns(const Mechanism& mechanism, const SymbolicEquations& e) {
  std::vector<int> columns;
  const std::size_t free = e.M.size() - std::min(e.A.size(), e.M.size());
  for (const int actuator : mechanism.actuators)
    for (std::size_t c = 0; c < e.M.size(); ++c)
      if (e.tree.coordinates[c] == actuator) columns.push_back(static_cast<int>(c));
  for (std::size_t c = 0; columns.size() < free && c < e.M.size(); ++c)
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
  section.zero.clear();  // nearly all of them
  return section;
}

void add_natural_notes(const Mechanism& mechanism, FormulaSheet& sheet) {
  std::string list;
  for (std::size_t k = 0; k < sheet.natural->points.size(); ++k)
    list += (k > 0 ? ", " : "") + std::to_string(k + 1) + " " + sheet.natural->points[k];
  sheet.notes.push_back("points: " + list + "; x and y of the first " +
                        std::to_string(sheet.natural->unknowns.size() / 2) +
                        " are the unknowns; blocks and derivatives that are not there vanish");
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
  std::string left;
  for (const std::string& kind : tree.excluded_terms) left += (left.empty() ? "" : ", ") + kind;
  if (!left.empty()) sheet.notes.push_back("left out of these formulas, which are functions of the pose: " + left);
  if (has_velocity_constraints(mechanism))
    sheet.notes.push_back("these are the equations of all coordinates, before rates are bound");
  if (!mechanism.couplings.empty()) sheet.notes.push_back("coordinates that follow others are moved along with these");
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

FormulaSheet make_sheet(const Mechanism& mechanism, const SpecNumberTexts& texts, const SheetOptions& options) {
  FormulaSheet sheet;
  sheet.ring = std::make_unique<Ring>();
  const bool linear =
      std::find(options.only.begin(), options.only.end(), SheetSectionKind::regressor) != options.only.end();
  const bool natural =
      std::find(options.only.begin(), options.only.end(), SheetSectionKind::natural) != options.only.end();
  const TreeOptions tree{linear ? InertialParametrisation::about_origin : InertialParametrisation::about_com,
                         options.expressions, natural};
  sheet.equations = derive_equations(*sheet.ring, build_symbolic_tree(*sheet.ring, mechanism, texts, tree));
  const SymbolicEquations& e = sheet.equations;
  const auto add = [&](SheetSectionKind section, auto&& make) {
    if (!is_wanted(options, section)) return;
    SheetSection made = make();
    if (!made.formulas.empty() || !made.zero.empty()) sheet.sections.push_back(std::move(made));
  };
  add(SheetSectionKind::inertia, [&] { return make_inertia_section(e); });
  add(SheetSectionKind::velocity, [&] { return make_velocity_section(e); });
  add(SheetSectionKind::gravity, [&] { return make_gravity_section(e); });
  if (!e.closure.empty()) {
    add(SheetSectionKind::closures, [&] { return make_closure_section(e); });
    add(SheetSectionKind::solved, [&] { return make_solved_section(mechanism, e); });
  }
  if (e.closure.empty() && !has_velocity_constraints(mechanism) && is_wanted(options, SheetSectionKind::conditions))
    for (SheetSection& section : make_condition_sections(e)) sheet.sections.push_back(std::move(section));
  if (linear) {
    sheet.regressor = derive_regressor(*sheet.ring, e);
    add(SheetSectionKind::regressor, [&] { return make_regressor_section(*sheet.regressor); });
  }
  if (natural) {
    sheet.natural = derive_natural_equations(*sheet.ring, *e.tree.basic_points);
    add(SheetSectionKind::natural, [&] { return make_natural_section(*sheet.natural); });
  }
  add_notes(mechanism, sheet);
  return sheet;
}

}  // namespace balance::formulas
