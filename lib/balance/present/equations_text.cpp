#include "balance/base/elementary.hpp"
#include "balance/base/extrema.hpp"
#include "balance/present/equation_tables.hpp"
#include "balance/present/equations_view.hpp"
#include "balance/write/table.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>

namespace balance {

namespace {

std::string numbers_line(const char* label, const std::vector<std::string>& names, const VectorX& values) {
  std::vector<std::string> parts;
  for (std::size_t k = 0; k < names.size(); ++k)
    parts.push_back(fmt::format("{} = {:.9g}", names[k], values[static_cast<Eigen::Index>(k)]));
  return fmt::format("{}{}\n", label, fmt::join(parts, ", "));
}

std::vector<std::string> rates_of(std::vector<std::string> names) {
  for (std::string& name : names) name += "'";
  return names;
}

std::string rest_text(const EquationsAtConfiguration& at) {
  const StaticTerms& rest = at.terms->static_terms;
  const double size = std::max({at.torque_scale, max_abs(rest.weight), max_abs(rest.springs), max_abs(rest.loads)});
  TextTable table{{"", "weight", "springs", "loads", "z'", ""},
                  {Align::left, Align::right, Align::right, Align::right, Align::right, Align::left},
                  {}};
  for (std::size_t k = 0; k < at.independent.size(); ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    table.rows.push_back({"  " + at.independent[k], format_entry(rest.weight[i], size),
                          format_entry(rest.springs[i], size), format_entry(rest.loads[i], size),
                          format_entry(rest.sum()[i], size), force_unit(at.is_length[k])});
  }
  return format_table(table);
}

std::string split_text(const EquationsAtConfiguration& at) {
  TextTable table{{""}, {Align::left}, {}};
  for (const char* name : effort_part_names) {
    table.heading.emplace_back(name);
    table.align.push_back(Align::right);
  }
  table.heading.insert(table.heading.end(), {"sum", ""});
  table.align.insert(table.align.end(), {Align::right, Align::left});
  const MatrixX& parts = at.split->parts;
  const double size = std::max(at.torque_scale, max_abs(parts));
  for (std::size_t a = 0; a < at.actuators.size(); ++a) {
    const auto row = parts.row(static_cast<Eigen::Index>(a));
    std::vector<std::string> cells{"  " + at.actuators[a]};
    for (const double value : row) cells.push_back(format_entry(value, size));
    cells.push_back(format_entry(at.split->effort[static_cast<Eigen::Index>(a)], size));
    cells.push_back(force_unit(at.is_force[a]));
    table.rows.push_back(std::move(cells));
  }
  return format_table(table);
}

std::string redundant_text(const EquationsAtConfiguration& at) {
  const RedundantTerms& loops = *at.loops;
  std::string text = "M in the tree's coordinates (P0 eq. 19)\n" + matrix_text(loops.mass, at.redundant, at.redundant);
  text += "\nC: tree coordinates' rates per independent rate, A C = 0 (P0 eq. 16)\n" +
          matrix_text(loops.transformation, at.redundant, at.independent);
  if (loops.constraints.rows() > 0)
    text += "\nA: closures (P0 eq. 7, 15)\n" + matrix_text(loops.constraints, at.closures, at.redundant);
  text += "\nz: weight, springs and loads\n" + matrix_text(loops.rest.sum(), at.redundant, {"z"});
  return text + "\n";
}

std::string natural_text(const natural::NaturalTerms& n) {
  std::string text = fmt::format("natural coordinates (P3): {} points, {} of them move\n", n.points.size(), n.moving);
  TextTable table{{"point", "x [m]", "y [m]", "C_P [kg]", ""},
                  {Align::left, Align::right, Align::right, Align::right, Align::left},
                  {}};
  for (std::size_t p = 0; p < n.points.size(); ++p) {
    const auto& c = n.coefficients[p].coefficient;
    const double size = n.total_mass;
    table.rows.push_back({"  " + n.points[p], fmt::format("{:.6g}", n.position(static_cast<Eigen::Index>(p), 0)),
                          fmt::format("{:.6g}", n.position(static_cast<Eigen::Index>(p), 1)),
                          fmt::format("[{} {}; {} {}]", format_entry(c.real(), size), format_entry(-c.imag(), size),
                                      format_entry(c.imag(), size), format_entry(c.real(), size)),
                          n.coefficients[p].fixed ? "fixed" : ""});
  }
  text += format_table(table);
  std::vector<std::string> entries;
  for (const std::string& point : n.points)
    for (const char* axis : {".x", ".y"}) entries.push_back(point + axis);
  text += "\nM [kg] (P3 eq. 35)\n" + matrix_text(n.mass, entries, entries);
  for (const std::string& rotor : n.rotors) text += "  disc: " + rotor + "\n";
  text += fmt::format("\nconstraints, points divided by {:.9g} m (P3 eq. 30)\n", n.unit);
  for (const std::string& row : n.constraints) text += "  " + row + "\n";
  return text + "\n";
}

std::string regressor_text(const EquationsAtConfiguration& at) {
  std::vector<std::string> names;
  for (const Parameter& p : at.regressor->parameters) names.push_back(p.name);
  return "regressor Y, effort = Y pi + other, and the parameters pi\n" + [&] {
    MatrixX all(at.regressor->effort.cols(), at.regressor->effort.rows() + 1);
    all << at.regressor->values, at.regressor->effort.transpose();
    std::vector<std::string> columns{"pi"};
    columns.insert(columns.end(), at.actuators.begin(), at.actuators.end());
    std::string text;
    TextTable table{{""}, {Align::left}, {}};
    for (const std::string& c : columns) table.heading.push_back(c), table.align.push_back(Align::right);
    for (Eigen::Index r = 0; r < all.rows(); ++r) {
      std::vector<std::string> cells{"  " + names[static_cast<std::size_t>(r)]};
      for (Eigen::Index c = 0; c < all.cols(); ++c)
        cells.push_back(format_entry(all(r, c), c == 0 ? 0 : max_abs(all.col(c))));
      table.rows.push_back(std::move(cells));
    }
    return format_table(table);
  }() + "\n";
}

std::string parameters_text(const EquationsAtConfiguration& at) {
  const Conditions& c = *at.parameters;
  std::string text =
      fmt::format("base parameters: {} of {} inertial parameters' combinations occur", c.rank, c.parameters.size());
  if (c.rank > 0 && c.singular_value_gap > 0)
    text += fmt::format(" (gap {:.1f} decades)", elementary::log10(c.singular_value_gap));
  text += "\n";
  for (int row = 0; row < c.rank; ++row)
    text += fmt::format("  {:>3}  {}\n", row + 1, base_parameter_text(c, row, at.parameter_names));
  return text + "\n";
}

}  // namespace

std::string inertia_unit(bool first_length, bool second_length) {
  return first_length && second_length ? "kg" : first_length || second_length ? "kg m" : "kg m^2";
}

std::string force_unit(bool length) { return length ? "N" : "N m"; }

std::string base_parameter_text(const Conditions& parameters, int row, const ConditionNames& names) {
  std::string text = condition_text(parameters, row, names);
  return text.substr(0, text.rfind(" = "));
}

std::string equations_text(const EquationsReportData& view) {
  using enum EquationSection;
  const EquationsAtConfiguration& at = view.at;
  std::string text = view.title + "\n" + numbers_line("at  ", view.coordinates, at.configuration) +
                     "independent coordinates  " + fmt::format("{}; SI units\n\n", fmt::join(at.independent, ", "));
  if (view.shows(inertia))
    text += "M' (P0 eq. 62; P1 eq. 14: D_ij)\n" + matrix_text(at.terms->mass, at.independent, at.independent) + "\n";
  if (view.shows(velocity)) {
    text += "velocity terms: D'_krs (P0 eq. 63; P1 eq. 15: D_ijk)\n" +
            velocity_table(*at.terms, at.independent, rates_of(at.independent));
    if (!at.terms->viscous.isZero(0))
      text += "B' (P0 eq. 63), of viscous friction\n" + matrix_text(at.terms->viscous, at.independent, at.independent);
    text += "\n";
  }
  if (view.shows(gravity)) text += "z' (P0 eq. 62; P1 eq. 16: D_i)\n" + rest_text(at) + "\n";
  if (at.in_speeds) text += speeds_text(view);
  if (at.diagonal_factors && view.shows(inertia))
    text +=
        numbers_line("decoupled there: u = k q'' (P1 eq. 27) with k  ", at.independent, *at.diagonal_factors) + "\n";
  if (at.split && view.shows(torques)) {
    text += "torques and what they add up from\n" + numbers_line("  rates  ", at.independent, at.dq) +
            numbers_line("  accelerations  ", at.independent, at.ddq) + split_text(at) + "\n";
  }
  if (at.loops && view.shows(redundant)) text += redundant_text(at);
  if (at.natural) text += natural_text(*at.natural);
  if (at.regressor) text += regressor_text(at);
  if (at.parameters) text += parameters_text(at);
  for (const std::string& note : at.notes) text += "note: " + note + "\n";
  while (text.size() > 1 && text.ends_with("\n\n")) text.pop_back();
  return text;
}

}  // namespace balance
