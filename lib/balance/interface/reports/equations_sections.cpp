#include "balance/interface/reports/equations_sections.hpp"

#include "balance/foundation/base/elementary.hpp"
#include "balance/foundation/base/latex_lines.hpp"
#include "balance/foundation/numerics/extrema.hpp"
#include "balance/interface/files/result_group.hpp"
#include "balance/interface/reports/conditions_sections.hpp"
#include "balance/synthesis/conditions/condition_text.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace balance::reports {

using files::Align;
using formulas::EquationsAtConfiguration;

namespace {

constexpr double zero_entry_tolerance = 1e-13;  ///< of the largest entry of its kind; shown as 0

/// Unit of the generalised inertia of two coordinates.
std::string inertia_unit(bool first_length, bool second_length) {
  return first_length && second_length ? "kg" : first_length || second_length ? "kg m" : "kg m^2";
}

/// Unit of a generalised force.
std::string force_unit(bool length) { return length ? "N" : "N m"; }

/// One base parameter: "link1.J + l1^2 link2.m".
std::string base_parameter_text(const Conditions& parameters, int row, const conditions::ConditionNames& names) {
  std::string text = condition_text(parameters, row, names);
  return text.substr(0, text.rfind(" = "));
}

/// Six significant digits; 0 for round-off.
std::string format_entry(double value, double max_entry) {
  return std::abs(value) <= zero_entry_tolerance * max_entry ? "0" : fmt::format("{:.6g}", value);
}

/// @param max_entries per column, of which smaller ones are round-off
std::string table_of_entries(const MatrixX& matrix, const std::vector<std::string>& rows,
                             const std::vector<std::string>& columns, const std::vector<double>& max_entries,
                             std::size_t width) {
  files::TextTable table{{""}, {Align::left}, {}};
  table.heading.insert(table.heading.end(), columns.begin(), columns.end());
  table.align.resize(table.heading.size(), Align::right);
  for (Eigen::Index r = 0; r < matrix.rows(); ++r) {
    std::vector<std::string> cells{"  " + rows[static_cast<std::size_t>(r)]};
    for (Eigen::Index c = 0; c < matrix.cols(); ++c)
      cells.push_back(format_entry(matrix(r, c), max_entries[static_cast<std::size_t>(c)]));
    table.rows.push_back(std::move(cells));
  }
  return format_table(table, width);
}

std::string matrix_text(const MatrixX& matrix, const std::vector<std::string>& rows,
                        const std::vector<std::string>& columns, std::size_t width = files::default_text_width) {
  return table_of_entries(matrix, rows, columns, std::vector<double>(columns.size(), numerics::max_abs(matrix)), width);
}

/// "A1: 0.3 A1'^2 - 2 0.1 A1' A2'": the nonzero terms. @param factors of the quadratic forms, "A1'"
/// @param linear coefficients of accelerations, of the same size
std::string velocity_table(const std::vector<MatrixX>& forms, const MatrixX& linear,
                           const std::vector<std::string>& rows, const std::vector<std::string>& factors) {
  double max_entry = 1e-3 * numerics::max_abs(linear);
  for (const MatrixX& form : forms) max_entry = std::max(max_entry, numerics::max_abs(form));
  std::string text;
  for (std::size_t k = 0; k < forms.size(); ++k) {
    const MatrixX& form = forms[k];
    std::string sum;
    for (Eigen::Index r = 0; r < form.rows(); ++r)
      for (Eigen::Index s = r; s < form.cols(); ++s) {
        if (std::abs(form(r, s)) <= zero_entry_tolerance * max_entry) continue;
        const auto& first = factors[static_cast<std::size_t>(r)];
        const auto& second = factors[static_cast<std::size_t>(s)];
        sum += sum.empty() ? (form(r, s) < 0 ? "-" : "") : form(r, s) < 0 ? " - " : " + ";
        sum += fmt::format("{}{:.6g} {}", r == s ? "" : "2 ", std::abs(form(r, s)),
                           r == s ? first + "^2" : first + " " + second);
      }
    text += fmt::format("  {}: {}\n", rows[k], sum.empty() ? "0" : sum);
  }
  return text;
}

using Dimension = hdf5::Hdf5Writer::Dimension;

void add_variables(hdf5::Hdf5Writer& file, const formulas::EquationsAlongRun& run,
                   const std::vector<std::string>& actuators) {
  const Dimension time =
      file.add_dimension(hdf5::root_group, {"time", "time", "s", {}, {}}, hdf5::entries_of(run.time));
  const Dimension independent =
      file.add_dimension(hdf5::root_group, {"coordinate", "independent coordinate", "1", {}, {}}, run.independent);
  const Dimension rate =
      file.add_dimension(hdf5::root_group, {"rate", "rate of an independent coordinate", "1", {}, {}}, run.independent);
  const Dimension rate2 = file.add_dimension(
      hdf5::root_group, {"second_rate", "rate of an independent coordinate", "1", {}, {}}, run.independent);
  const Dimension tree =
      file.add_dimension(hdf5::root_group, {"tree", "coordinate of the tree", "1", {}, {}}, run.redundant);
  const auto add = [&](const char* name, const char* long_name, const std::vector<Dimension>& dimensions,
                       const Samples& samples) {
    if (samples.size() > 0)
      file.add_variable(hdf5::root_group, {name, long_name, "mixed", dimensions, {}}, hdf5::entries_of(samples));
  };
  add("position", "independent coordinates [rad or m]", {time, independent}, run.position);
  add("M", "M': inertia in the independent coordinates, P0 eq. 62", {time, independent, rate}, run.mass);
  add("D", "D'_krs: velocity terms, P0 eq. 63", {time, independent, rate, rate2}, run.velocity);
  add("B", "B': viscous friction, P0 eq. 63", {time, independent, rate}, run.viscous);
  add("z", "z': weight, springs and loads, P0 eq. 62", {time, independent}, run.static_terms);
  add("C", "rates of the tree's coordinates per independent rate, P0 eq. 16", {time, tree, independent},
      run.transformation);
  if (!run.disc_rows.empty()) {
    const Dimension disc = file.add_dimension(
        hdf5::root_group, {"disc", "rotation of a disc about its own axes", "1", {}, {}}, run.disc_rows);
    add("C_discs", "the discs' rotations per independent rate, P1 eq. 24", {time, disc, independent}, run.discs);
  }
  add("rate_offset", "rates of the tree's coordinates at zero independent rates, due to prescribed speeds",
      {time, tree}, run.rate_offset);
  if (!run.closures.empty()) {
    const Dimension closure =
        file.add_dimension(hdf5::root_group, {"closure", "joint that is closed", "1", {}, {}}, run.closures);
    add("A", "closures' Jacobian, P0 eq. 7", {time, closure, tree}, run.constraints);
  }
  if (run.parts.size() == 0) return;
  const std::vector<std::string> parts(dynamics::effort_part_names.begin(), dynamics::effort_part_names.end());
  const Dimension actuator =
      file.add_dimension(hdf5::root_group, {"actuator", "actuated coordinate", "1", {}, {}}, actuators);
  const Dimension part = file.add_dimension(hdf5::root_group, {"part", "part of the torque", "1", {}, {}}, parts);
  add("torque", "parts of the torques, which add up to them [N m or N]", {time, actuator, part}, run.parts);
}

}  // namespace

void write_equations(const std::string& path, const formulas::EquationsAlongRun& run,
                     const std::vector<std::string>& actuators, const files::Provenance& description,
                     const files::WriteOptions& options) {
  write_hdf5_file(path, description, options, [&](hdf5::Hdf5Writer& file) { add_variables(file, run, actuators); });
}

namespace {

MatrixX stack_rows(const MatrixX& above, const MatrixX& below) {
  MatrixX stack(above.rows() + below.rows(), above.cols());
  stack.topRows(above.rows()) = above;
  stack.bottomRows(below.rows()) = below;
  return stack;
}

Json matrix_json(const MatrixX& matrix) {
  return files::list_json(matrix.rowwise(), [](const auto& row) { return files::numbers_json(row.transpose()); });
}

Json forms_json(const std::vector<MatrixX>& forms) { return files::list_json(forms, matrix_json); }

Json rest_json(const dynamics::StaticTerms& static_terms) {
  Json json = {{"sum", files::numbers_json(static_terms.sum())},
               {"weight", files::numbers_json(static_terms.weight)},
               {"springs", files::numbers_json(static_terms.springs)},
               {"loads", files::numbers_json(static_terms.loads)}};
  if (static_terms.prescribed.size() > 0) json["prescribed"] = files::numbers_json(static_terms.prescribed);
  return json;
}

Json split_json(const EquationsAtConfiguration& at) {
  Json json = Json::object();
  for (std::size_t a = 0; a < at.actuators.size(); ++a) {
    const auto row = static_cast<Eigen::Index>(a);
    Json parts = files::named_numbers_json({dynamics::effort_part_names.begin(), dynamics::effort_part_names.end()},
                                           at.split->parts.row(row).transpose());
    parts["sum"] = at.split->effort[row];
    parts["unit"] = force_unit(at.is_force[a]);
    json[at.actuators[a]] = parts;
  }
  return json;
}

Json terms_json(const dynamics::IndependentTerms& terms) {
  return {{"M", matrix_json(terms.mass)},
          {"D", forms_json(terms.velocity)},
          {"B", matrix_json(terms.viscous)},
          {"z", rest_json(terms.static_terms)},
          {"input", matrix_json(terms.input)}};
}

std::vector<std::string> independent_speeds(const EquationsAtConfiguration& at) {
  std::vector<std::string> names;
  for (const int k : at.in_speeds->independent) names.push_back(at.speeds[static_cast<std::size_t>(k)]);
  return names;
}

/// Of more speeds p than freedoms: A with A p = A c₀, one row for each dependent speed (P0 eq. 6, 15).
MatrixX speed_relations(const dynamics::SpeedTerms& terms) {
  const MatrixX& C = terms.transformation;
  MatrixX A(C.rows() - C.cols(), C.rows());
  Eigen::Index row = 0;
  for (int k = 0; k < static_cast<int>(C.rows()); ++k) {
    if (std::binary_search(terms.independent.begin(), terms.independent.end(), k)) continue;
    A.row(row) = VectorX::Unit(C.rows(), k).transpose();
    for (Eigen::Index s = 0; s < C.cols(); ++s) A(row, terms.independent[static_cast<std::size_t>(s)]) = -C(k, s);
    ++row;
  }
  return A;
}

Json speeds_json(const EquationsAtConfiguration& at) {
  const dynamics::SpeedTerms& speeds = *at.in_speeds;
  Json json = terms_json(speeds.speed_equations);
  json["speeds"] = at.speeds;
  json["independent"] = independent_speeds(at);
  json["rows"] = matrix_json(speeds.rows);
  json["rates"] = matrix_json(speeds.rates);
  json["constraints"] = at.zero;
  json["freedoms"] = {{"configuration", at.independent.size()}, {"velocity", speeds.independent.size()}};
  json["held"] = terms_json(speeds.constraint_equations);
  json["C"] = matrix_json(speeds.transformation);
  json["c"] = forms_json(speeds.acceleration);
  json["A"] = matrix_json(speed_relations(speeds));
  if (speeds.rate_offset.size() == 0) return json;
  json["rate_offset"] = files::numbers_json(speeds.rate_offset);
  json["speed_offset"] = files::numbers_json(speeds.speed_offset);
  json["acceleration_linear"] = matrix_json(speeds.acceleration_linear);
  json["acceleration_offset"] = files::numbers_json(speeds.acceleration_offset);
  return json;
}

Json redundant_json(const EquationsAtConfiguration& at) {
  const dynamics::RedundantTerms& loops = *at.loops;
  Json json = {{"coordinates", at.redundant},
               {"closures", at.closures},
               {"M", matrix_json(loops.mass)},
               {"D", forms_json(loops.velocity)},
               {"B", matrix_json(loops.viscous)},
               {"z", rest_json(loops.rest)},
               {"S", matrix_json(loops.input)},
               {"A", matrix_json(loops.constraints)},
               {"C", matrix_json(loops.transformation)},
               {"c", forms_json(loops.acceleration)},
               {"discs", at.disc_rows},
               {"C_discs", matrix_json(loops.discs)}};
  if (loops.constraint_speeds.size() == 0) return json;
  json["constraint_speeds"] = files::numbers_json(loops.constraint_speeds);
  json["rate_offset"] = files::numbers_json(loops.rate_offset);
  json["acceleration_linear"] = matrix_json(loops.acceleration_linear);
  json["acceleration_offset"] = files::numbers_json(loops.acceleration_offset);
  return json;
}

Json natural_json(const verification::natural::NaturalTerms& n) {
  Json json = {{"points", n.points},
               {"moving", n.moving},
               {"coordinates", n.coordinates},
               {"position", matrix_json(n.position)},
               {"M", matrix_json(n.mass)},
               {"discs", n.rotors},
               {"unit", n.unit},
               {"constraints", n.constraints},
               {"residual", files::numbers_json(n.residual)},
               {"J", matrix_json(n.jacobian)},
               {"total_mass", n.total_mass}};
  json["C_P"] = Json::object();
  for (const verification::natural::PointMatrix& one : n.coefficients) {
    const double re = one.coefficient.real(), im = one.coefficient.imag();
    json["C_P"][one.point] = {{re, -im}, {im, re}};
  }
  return json;
}

Json regressor_json(const dynamics::EffortRegressor& regressor) {
  std::vector<std::string> names;
  for (const dynamics::Parameter& p : regressor.parameters) names.push_back(p.name);
  return {{"parameters", names},
          {"values", files::numbers_json(regressor.values)},
          {"effort", matrix_json(regressor.effort)},
          {"shaking_force", matrix_json(regressor.shaking_force)},
          {"shaking_moment", matrix_json(regressor.shaking_moment)},
          {"other", files::numbers_json(regressor.constant_effort)}};
}

Json parameters_json(const EquationsAtConfiguration& at) {
  const Conditions& c = *at.parameters;
  std::vector<std::string> names, texts;
  for (const dynamics::Parameter& p : c.parameters) names.push_back(p.name);
  for (int row = 0; row < c.rank; ++row) texts.push_back(base_parameter_text(c, row, at.parameter_names));
  return {{"rank", c.rank},        {"gap", c.singular_value_gap}, {"parameters", names},
          {"combinations", texts}, {"pivots", c.pivots},          {"matrix", matrix_json(c.matrix)}};
}

}  // namespace

std::string equations_json(const EquationsReportData& view, const std::vector<std::string>& warnings) {
  using enum formulas::EquationSection;
  const EquationsAtConfiguration& at = view.at;
  Json json = {{"mechanism", view.title},
               {"configuration", files::named_numbers_json(view.coordinates, at.configuration)},
               {"independent", at.independent},
               {"actuators", at.actuators},
               {"q", files::numbers_json(at.q)},
               {"rates", files::numbers_json(at.dq)},
               {"accelerations", files::numbers_json(at.ddq)}};
  if (view.shows(inertia)) json["M"] = matrix_json(at.terms->mass);
  if (view.shows(inertia)) json["input"] = matrix_json(at.terms->input);
  if (view.shows(velocity)) json["D"] = forms_json(at.terms->velocity);
  if (view.shows(velocity)) json["B"] = matrix_json(at.terms->viscous);
  if (view.shows(gravity)) json["z"] = rest_json(at.terms->static_terms);
  if (at.in_speeds) json["in_speeds"] = speeds_json(at);
  if (at.diagonal_factors) json["k"] = files::numbers_json(*at.diagonal_factors);
  if (at.split && view.shows(torques)) json["torques"] = split_json(at);
  if (at.loops && view.shows(redundant)) json["redundant"] = redundant_json(at);
  if (at.natural) json["natural"] = natural_json(*at.natural);
  if (at.regressor) json["regressor"] = regressor_json(*at.regressor);
  if (at.parameters) json["base_parameters"] = parameters_json(at);
  json["notes"] = at.notes;
  json["warnings"] = warnings;
  return files::format_json(json);
}

namespace {

constexpr Eigen::Index max_matrix_rows = 36;  ///< a page has room for about so many

std::string number_latex(double value, double max_entry) {
  if (std::abs(value) <= zero_entry_tolerance * max_entry) return "0";
  std::string text = fmt::format("{:.6g}", value);
  if (const std::size_t e = text.find('e'); e != std::string::npos)
    text = fmt::format("{} \\cdot 10^{{{}}}", text.substr(0, e), std::stoi(text.substr(e + 1)));
  return text;
}

/// The rows and columns [row, row + rows) and [column, column + columns) of a matrix.
struct MatrixBlock {
  Eigen::Index row = 0, rows = 0, column = 0, columns = 0;
};

class AlignedLines {
 public:
  /// A formula, broken where it is wider than a line.
  void add(const std::string& name, const std::string& formula) {
    const std::vector<std::string> lines =
        break_latex(formula, latex_line_width - latex_width(name) - relation_width - indent_width);
    std::string value = lines.at(0);
    for (std::size_t k = 1; k < lines.size(); ++k) value += " \\\\\n  &\\quad {}" + lines[k];
    add_line(name, value);
  }

  /// A matrix; one that is wider than a line or longer than a page in blocks, named as M(1:36, 1:5).
  void add(const std::string& name, const MatrixX& matrix) {
    const std::vector<std::vector<std::string>> entries = print_entries(matrix);
    const std::vector<MatrixBlock> blocks = list_blocks(entries, matrix.cols(), latex_width(name));
    for (const MatrixBlock& block : blocks) {
      const std::string part = fmt::format("({}{{:}}{},\\, {}{{:}}{})", block.row + 1, block.row + block.rows,
                                           block.column + 1, block.column + block.columns);
      add_line(blocks.size() > 1 ? name + part : name, block_latex(entries, block));
      max_columns_ = std::max(max_columns_, block.columns);
    }
  }

  std::string to_latex() const {
    constexpr Eigen::Index default_max_columns = 10;  // of amsmath's matrices
    const std::string preamble = max_columns_ > default_max_columns
                                     ? fmt::format("\\setcounter{{MaxMatrixCols}}{{{}}}\n", max_columns_)
                                     : std::string();
    return preamble + "\\begin{align*}\n" + text_ + "\n\\end{align*}\n";
  }

 private:
  static constexpr double relation_width = 2, indent_width = 2;  ///< in letters
  static constexpr double digit_width = 0.7, column_gap = 1.4, block_name_width = 6;

  void add_line(const std::string& name, const std::string& value) {
    text_ += (text_.empty() ? "  " : " \\\\\n  ") + name + " &= " + value;
  }

  static std::vector<std::vector<std::string>> print_entries(const MatrixX& matrix) {
    const double max_entry = numerics::max_abs(matrix);
    std::vector<std::vector<std::string>> entries(static_cast<std::size_t>(matrix.rows()));
    for (Eigen::Index r = 0; r < matrix.rows(); ++r)
      for (Eigen::Index c = 0; c < matrix.cols(); ++c)
        entries[static_cast<std::size_t>(r)].push_back(number_latex(matrix(r, c), max_entry));
    return entries;
  }

  /// One block if the matrix fits.
  static std::vector<MatrixBlock> list_blocks(const std::vector<std::vector<std::string>>& entries,
                                              Eigen::Index columns, double name_width) {
    std::vector<double> widths(static_cast<std::size_t>(columns), column_gap);
    for (const std::vector<std::string>& row : entries)
      for (std::size_t c = 0; c < row.size(); ++c)
        widths[c] = std::max(widths[c], digit_width * latex_width(row[c]) + column_gap);
    const auto rows = static_cast<Eigen::Index>(entries.size());
    double limit = latex_line_width - name_width - relation_width - indent_width;
    const double whole = std::accumulate(widths.begin(), widths.end(), 0.0);
    if (whole > limit) limit -= block_name_width;
    std::vector<MatrixBlock> blocks;
    for (Eigen::Index row = 0; row < std::max<Eigen::Index>(rows, 1); row += max_matrix_rows) {
      MatrixBlock block{row, std::min(max_matrix_rows, rows - row), 0, 0};
      double width = 0;
      for (Eigen::Index c = 0; c < columns; ++c) {
        const double added = widths[static_cast<std::size_t>(c)];
        if (block.columns > 0 && width + added > limit) {
          blocks.push_back(block);
          block.column = c, block.columns = 0, width = 0;
        }
        ++block.columns, width += added;
      }
      blocks.push_back(block);
    }
    return blocks;
  }

  static std::string block_latex(const std::vector<std::vector<std::string>>& entries, const MatrixBlock& block) {
    std::string text = "\\begin{pmatrix}";
    for (Eigen::Index r = 0; r < block.rows; ++r) {
      text += r == 0 ? " " : " \\\\ ";
      for (Eigen::Index c = 0; c < block.columns; ++c)
        text += (c == 0 ? "" : " & ") +
                entries[static_cast<std::size_t>(block.row + r)][static_cast<std::size_t>(block.column + c)];
    }
    return text + " \\end{pmatrix}";
  }

  std::string text_;
  Eigen::Index max_columns_ = 0;
};

}  // namespace

std::string equations_latex(const EquationsReportData& view) {
  using enum formulas::EquationSection;
  const EquationsAtConfiguration& at = view.at;
  AlignedLines lines;
  std::string names;
  for (const std::string& name : at.independent)
    names += (names.empty() ? "" : ",\\, ") + conditions::symbol_latex(name);
  lines.add("q", "\\left(" + names + "\\right)^{\\mathsf T}");
  if (view.shows(inertia)) lines.add("M'", at.terms->mass);
  if (view.shows(velocity))
    for (std::size_t k = 0; k < at.independent.size(); ++k)
      lines.add(fmt::format("D'_{{{}}}", k + 1), at.terms->velocity[k]);
  if (view.shows(velocity)) lines.add("B'", at.terms->viscous);
  if (view.shows(gravity)) lines.add("z'", at.terms->static_terms.sum());
  if (at.diagonal_factors && view.shows(inertia)) lines.add("k", *at.diagonal_factors);
  if (at.split && view.shows(torques)) lines.add("u", at.split->effort);
  if (at.loops && view.shows(redundant)) {
    lines.add("M", at.loops->mass);
    lines.add("C", stack_rows(at.loops->transformation, at.loops->discs));
    if (at.loops->constraints.rows() > 0) lines.add("A", at.loops->constraints);
    lines.add("z", at.loops->rest.sum());
  }
  if (at.natural) {
    lines.add("M_{\\text{points}}", at.natural->mass);
    for (const verification::natural::PointMatrix& one : at.natural->coefficients) {
      const double re = one.coefficient.real(), im = one.coefficient.imag();
      lines.add("C_{" + conditions::symbol_latex(one.point) + "}", (Eigen::Matrix2d() << re, -im, im, re).finished());
    }
  }
  if (at.parameters)
    for (int row = 0; row < at.parameters->rank; ++row) {
      std::string text = condition_latex(*at.parameters, row, at.parameter_names);
      lines.add(fmt::format("\\pi_{{{}}}", row + 1), text.substr(0, text.rfind(" = ")));
    }
  return lines.to_latex();
}

// The equations of motion in speeds, and the effect of constraints on them.

namespace {

/// For sections whose units differ from row to row, and which therefore remain SI.
std::string si_note(const specification::SpecUnits& units) { return files::has_other_units(units) ? ", SI" : ""; }

/// What B' is of.
std::string viscous_origin(const dynamics::IndependentTerms& terms) {
  return terms.static_terms.prescribed.size() > 0 ? "of viscous friction and prescribed speeds" : "of viscous friction";
}

/// Columns of z' with their headings.
std::pair<MatrixX, std::vector<std::string>> static_columns(const dynamics::StaticTerms& terms) {
  const bool has_prescribed = terms.prescribed.size() > 0;
  MatrixX columns(terms.weight.size(), has_prescribed ? 5 : 4);
  if (has_prescribed) {
    columns << terms.weight, terms.springs, terms.loads, terms.prescribed, terms.sum();
    return {columns, {"weight", "springs", "loads", "prescribed speeds", "z'"}};
  }
  columns << terms.weight, terms.springs, terms.loads, terms.sum();
  return {columns, {"weight", "springs", "loads", "z'"}};
}

std::string sections_text(const EquationsReportData& view, const dynamics::IndependentTerms& terms,
                          const std::vector<std::string>& rows, std::size_t width) {
  using enum formulas::EquationSection;
  const EquationsAtConfiguration& at = view.at;
  const std::vector<std::string> speeds = independent_speeds(at);
  std::string text;
  if (view.shows(inertia)) text += "M'\n" + matrix_text(terms.mass, rows, speeds, width);
  if (view.shows(velocity)) {
    text += "velocity terms\n" + velocity_table(terms.velocity, terms.mass, rows, speeds);
    if (!terms.viscous.isZero(0))
      text += "B', " + viscous_origin(terms) + "\n" + matrix_text(terms.viscous, rows, speeds, width);
  }
  if (view.shows(gravity)) {
    const auto [columns, headings] = static_columns(terms.static_terms);
    text += "z'\n" + matrix_text(columns, rows, headings, width);
  }
  if (view.shows(torques) && terms.input.cols() > 0)
    text += "input matrix: generalised force per effort\n" + matrix_text(terms.input, rows, at.actuators, width);
  return text;
}

/// All speeds by the independent ones, if there are more than freedoms or they have a part of their own.
std::string relations_text(const EquationsAtConfiguration& at, std::size_t width) {
  const dynamics::SpeedTerms& speeds = *at.in_speeds;
  const std::vector<std::string> independent = independent_speeds(at);
  std::string text;
  if (speeds.rate_offset.size() > 0)
    text += "rates of the coordinates when the speeds are zero\n" +
            matrix_text(speeds.rate_offset, at.independent, {"rate"}, width);
  if (speeds.transformation.rows() == speeds.transformation.cols()) return text;
  text += "C: all speeds per independent speed (P0 eq. 16)\n" +
          matrix_text(speeds.transformation, at.speeds, independent, width);
  if (speeds.speed_offset.size() > 0)
    text +=
        "speeds when the independent ones are zero\n" + matrix_text(speeds.speed_offset, at.speeds, {"speed"}, width);
  text += "derivatives of the speeds, besides C times those of the independent ones\n" +
          velocity_table(speeds.acceleration, speeds.transformation, at.speeds, independent);
  if (speeds.acceleration_linear.size() > 0) {
    MatrixX affine(speeds.acceleration_linear.rows(), speeds.acceleration_linear.cols() + 1);
    affine << speeds.acceleration_linear, speeds.acceleration_offset;
    std::vector<std::string> columns = independent;
    columns.emplace_back("constant");
    text += "and, due to prescribed speeds\n" + matrix_text(affine, at.speeds, columns, width);
  }
  return text;
}

/// The sections in the speeds.
std::string speeds_text(const EquationsReportData& view, const files::TextOptions& options) {
  const EquationsAtConfiguration& at = view.at;
  const dynamics::SpeedTerms& speed_terms = *at.in_speeds;
  const std::vector<std::string> independent = independent_speeds(at);
  std::string text = fmt::format("in the speeds {}", fmt::join(independent, ", "));
  if (independent.size() < at.speeds.size())
    text += fmt::format(", the first of {} that determine the motion", fmt::join(at.speeds, ", "));
  if (!at.zero.empty())
    text += fmt::format("; {}: {}", at.has_constraint_values ? "prescribed" : "zero", fmt::join(at.zero, ", "));
  text += si_note(options.units) + " (P0 eq. 1)\nfreedoms: ";
  if (!at.has_rate_constraints) text += fmt::format("{} of configuration, ", at.independent.size());
  text += fmt::format("{} of velocity\n", independent.size());
  text += "rates of the coordinates per speed\n" +
          matrix_text(speed_terms.rates, at.independent, independent, options.width);
  text += relations_text(at, options.width);
  text += sections_text(view, speed_terms.speed_equations, independent, options.width);
  if (!at.zero.empty())
    text += "\nforces of the constraints, efforts apart\n" +
            sections_text(view, speed_terms.constraint_equations, at.zero, options.width);
  return text + "\n";
}

/// @param si_units one per value
/// @param with_units whether to name the units
std::string numbers_line(const char* label, const std::vector<std::string>& names, const VectorX& values,
                         const std::vector<std::string>& si_units, const specification::SpecUnits& units,
                         bool with_units) {
  std::vector<std::string> parts;
  for (std::size_t k = 0; k < names.size(); ++k) {
    const files::DisplayUnit unit = files::find_display_unit(si_units[k], units);
    parts.push_back(fmt::format("{} = {:.9g}{}", names[k], unit.convert(values[static_cast<Eigen::Index>(k)]),
                                with_units ? append_unit(unit) : ""));
  }
  return fmt::format("{}{}\n", label, fmt::join(parts, ", "));
}

/// Units of coordinates or their rates.
std::vector<std::string> list_units(const std::vector<bool>& is_length, const char* per_time) {
  std::vector<std::string> units;
  for (const bool length : is_length) units.push_back(std::string(length ? "m" : "rad") + per_time);
  return units;
}

/// M', D', B' in display units; angles in radians. z' is converted where it is printed.
dynamics::IndependentTerms convert_matrices(dynamics::IndependentTerms terms, const std::vector<bool>& is_length,
                                            const specification::SpecUnits& units) {
  const auto count = static_cast<Eigen::Index>(is_length.size());
  const auto lengths = [&](std::initializer_list<Eigen::Index> coordinates) {
    int sum = 0;
    for (const Eigen::Index c : coordinates) sum += is_length[static_cast<std::size_t>(c)] ? 1 : 0;
    return sum;
  };
  const auto power_of_length = [&](int power) { return elementary::pow(units.length, power); };
  for (Eigen::Index i = 0; i < count; ++i)
    for (Eigen::Index j = 0; j < count; ++j) {
      terms.mass(i, j) /= units.mass * power_of_length(2 - lengths({i, j}));
      terms.viscous(i, j) /= units.force * units.time * power_of_length(1 - lengths({i, j}));
      for (Eigen::Index k = 0; k < count; ++k)
        terms.velocity[static_cast<std::size_t>(k)](i, j) /= units.mass * power_of_length(2 - lengths({i, j, k}));
    }
  return terms;
}

/// " [g mm^2]" if all coordinates are of one kind.
std::string uniform_unit(const std::vector<bool>& is_length, const char* of_angles, const char* of_lengths,
                         const specification::SpecUnits& units) {
  if (!files::has_other_units(units) || is_length.empty()) return "";
  for (const bool length : is_length)
    if (length != is_length.front()) return "";
  return bracket_unit(files::find_display_unit(is_length.front() ? of_lengths : of_angles, units));
}

std::string entry_text(double value, double max_entry, const files::DisplayUnit& unit) {
  return std::abs(value) <= zero_entry_tolerance * max_entry ? "0" : fmt::format("{:.6g}", unit.convert(value));
}

std::vector<std::string> rates_of(std::vector<std::string> names) {
  for (std::string& name : names) name += "'";
  return names;
}

std::string rest_text(const EquationsAtConfiguration& at, const files::TextOptions& options) {
  const dynamics::StaticTerms& static_terms = at.terms->static_terms;
  const auto [columns, headings] = static_columns(static_terms);
  const double max_entry = std::max(at.torque_scale, numerics::max_abs(columns.leftCols(columns.cols() - 1)));
  files::TextTable table{{""}, {Align::left}, {}};
  table.heading.insert(table.heading.end(), headings.begin(), headings.end());
  table.heading.emplace_back("");
  table.align.resize(table.heading.size() - 1, Align::right);
  table.align.push_back(Align::left);
  for (std::size_t k = 0; k < at.independent.size(); ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    const files::DisplayUnit unit = files::find_display_unit(force_unit(at.is_length[k]), options.units);
    std::vector<std::string> cells{"  " + at.independent[k]};
    for (const double value : columns.row(i)) cells.push_back(entry_text(value, max_entry, unit));
    cells.push_back(unit.name);
    table.rows.push_back(std::move(cells));
  }
  return format_table(table, options.width);
}

std::string split_text(const EquationsAtConfiguration& at, const files::TextOptions& options) {
  files::TextTable table{{""}, {Align::left}, {}};
  for (const char* name : dynamics::effort_part_names) {
    table.heading.emplace_back(name);
    table.align.push_back(Align::right);
  }
  table.heading.insert(table.heading.end(), {"sum", ""});
  table.align.insert(table.align.end(), {Align::right, Align::left});
  const MatrixX& parts = at.split->parts;
  const double max_entry = std::max(at.torque_scale, numerics::max_abs(parts));
  for (std::size_t a = 0; a < at.actuators.size(); ++a) {
    const auto row = parts.row(static_cast<Eigen::Index>(a));
    std::vector<std::string> cells{"  " + at.actuators[a]};
    const files::DisplayUnit unit = files::find_display_unit(force_unit(at.is_force[a]), options.units);
    for (const double value : row) cells.push_back(entry_text(value, max_entry, unit));
    cells.push_back(entry_text(at.split->effort[static_cast<Eigen::Index>(a)], max_entry, unit));
    cells.push_back(unit.name);
    table.rows.push_back(std::move(cells));
  }
  return format_table(table, options.width);
}

std::string redundant_text(const EquationsAtConfiguration& at, const files::TextOptions& options) {
  const dynamics::RedundantTerms& loops = *at.loops;
  std::string text = "M in the tree's coordinates" + si_note(options.units) + " (P0 eq. 19)\n" +
                     matrix_text(loops.mass, at.redundant, at.redundant, options.width);
  std::vector<std::string> rows = at.redundant;
  rows.insert(rows.end(), at.disc_rows.begin(), at.disc_rows.end());
  text += std::string("\nC: tree coordinates' rates") +
          (at.disc_rows.empty() ? "" : ", below them the discs' rotations (P1 eq. 24),") +
          " per independent rate, A C = 0 (P0 eq. 16)\n" +
          matrix_text(stack_rows(loops.transformation, loops.discs), rows, at.independent, options.width);
  if (loops.constraints.rows() > 0)
    text += "\nA: closures (P0 eq. 7, 15)\n" + matrix_text(loops.constraints, at.closures, at.redundant, options.width);
  if (loops.rate_offset.size() > 0)
    text += "\nrates of the tree's coordinates when the independent ones are zero\n" +
            matrix_text(loops.rate_offset, at.redundant, {"rate"}, options.width);
  text += "\nz: weight, springs and loads" + si_note(options.units) + "\n" +
          matrix_text(loops.rest.sum(), at.redundant, {"z"}, options.width);
  return text + "\n";
}

std::string natural_text(const verification::natural::NaturalTerms& n, const files::TextOptions& options) {
  const files::DisplayUnit length = files::find_display_unit("m", options.units),
                           mass = files::find_display_unit("kg", options.units);
  std::string text = fmt::format("natural coordinates (P3): {} points, {} of them move\n", n.points.size(), n.moving);
  files::TextTable table{
      {"point", "x" + bracket_unit(length), "y" + bracket_unit(length), "C_P" + bracket_unit(mass), ""},
      {Align::left, Align::right, Align::right, Align::right, Align::left},
      {}};
  for (std::size_t p = 0; p < n.points.size(); ++p) {
    const auto& c = n.coefficients[p].coefficient;
    const double max_entry = n.total_mass;
    table.rows.push_back(
        {"  " + n.points[p], fmt::format("{:.6g}", length.convert(n.position(static_cast<Eigen::Index>(p), 0))),
         fmt::format("{:.6g}", length.convert(n.position(static_cast<Eigen::Index>(p), 1))),
         fmt::format("[{} {}; {} {}]", entry_text(c.real(), max_entry, mass), entry_text(-c.imag(), max_entry, mass),
                     entry_text(c.imag(), max_entry, mass), entry_text(c.real(), max_entry, mass)),
         n.coefficients[p].fixed ? "fixed" : ""});
  }
  text += format_table(table, options.width);
  std::vector<std::string> entries;
  for (const std::string& point : n.points)
    for (const char* axis : {".x", ".y"}) entries.push_back(point + axis);
  text += "\nM" + bracket_unit(mass) + " (P3 eq. 35)\n" +
          matrix_text(n.mass / mass.factor, entries, entries, options.width);
  for (const std::string& rotor : n.rotors) text += "  disc: " + rotor + "\n";
  text += fmt::format("\nconstraints, points divided by {:.9g} {} (P3 eq. 30)\n", length.convert(n.unit), length.name);
  for (const std::string& row : n.constraints) text += "  " + row + "\n";
  return text + "\n";
}

std::string regressor_text(const EquationsAtConfiguration& at, const files::TextOptions& options) {
  std::vector<std::string> names, columns{"pi"};
  for (const dynamics::Parameter& p : at.regressor->parameters) names.push_back(p.name);
  columns.insert(columns.end(), at.actuators.begin(), at.actuators.end());
  MatrixX entries(at.regressor->effort.cols(), at.regressor->effort.rows() + 1);
  entries << at.regressor->values, at.regressor->effort.transpose();
  std::vector<double> max_entries{0};
  for (Eigen::Index c = 1; c < entries.cols(); ++c) max_entries.push_back(numerics::max_abs(entries.col(c)));
  return "regressor Y, effort = Y pi + other, and the parameters pi" + si_note(options.units) + "\n" +
         table_of_entries(entries, names, columns, max_entries, options.width) + "\n";
}

std::string parameters_text(const EquationsAtConfiguration& at, const specification::SpecUnits& units) {
  ConditionsReportData shown;
  shown.conditions = *at.parameters;
  shown.names = at.parameter_names;
  shown = convert_coefficients(std::move(shown), units);
  const Conditions& c = shown.conditions;
  std::string text =
      fmt::format("base parameters: {} combinations of {} inertial parameters occur", c.rank, c.parameters.size());
  if (c.rank > 0 && c.singular_value_gap > 0)
    text += fmt::format(" (gap {:.1f} decades)", elementary::log10(c.singular_value_gap));
  text += "\n";
  for (int row = 0; row < c.rank; ++row)
    text += fmt::format("  {:>3}  {}\n", row + 1, base_parameter_text(c, row, shown.names));
  if (const std::string legend = parameter_legend(shown); !legend.empty()) text += "where " + legend + "\n";
  return text + "\n";
}

/// "SI units", or which others.
std::string units_text(const specification::SpecUnits& units) {
  if (!files::has_other_units(units)) return "SI units";
  return fmt::format("in {}, {}, {}, {}, {} and {}; matrices are for angles in rad", units.length_name, units.mass_name,
                     units.time_name, units.angle_name, files::find_display_unit("N", units).name,
                     files::find_display_unit("N m", units).name);
}

}  // namespace

std::string equations_text(const EquationsReportData& view, const files::TextOptions& options) {
  using enum formulas::EquationSection;
  const EquationsAtConfiguration& at = view.at;
  const specification::SpecUnits& units = options.units;
  const bool with_units = files::has_other_units(units);
  std::string text =
      view.title + "\n" +
      numbers_line("at  ", view.coordinates, at.configuration, list_units(view.is_length, ""), units, with_units) +
      "independent coordinates  " + fmt::format("{}; {}\n\n", fmt::join(at.independent, ", "), units_text(units));
  const dynamics::IndependentTerms terms = convert_matrices(*at.terms, at.is_length, units);
  if (view.shows(inertia))
    text += "M'" + uniform_unit(at.is_length, "kg m^2", "kg", units) + " (P0 eq. 62; P1 eq. 14: D_ij)\n" +
            matrix_text(terms.mass, at.independent, at.independent, options.width) + "\n";
  if (view.shows(velocity)) {
    text += "velocity terms: D'_krs" + uniform_unit(at.is_length, "kg m^2", "kg/m", units) +
            " (P0 eq. 63; P1 eq. 15: D_ijk)\n" +
            velocity_table(terms.velocity, terms.mass, at.independent, rates_of(at.independent));
    if (!at.terms->viscous.isZero(0))
      text += "B'" + uniform_unit(at.is_length, "N m s", "N s/m", units) + " (P0 eq. 63), " + viscous_origin(terms) +
              "\n" + matrix_text(terms.viscous, at.independent, at.independent, options.width);
    text += "\n";
  }
  if (view.shows(gravity)) text += "z' (P0 eq. 62; P1 eq. 16: D_i)\n" + rest_text(at, options) + "\n";
  if (at.in_speeds) text += speeds_text(view, options);
  if (at.diagonal_factors && view.shows(inertia)) {
    std::vector<std::string> inertia_units;
    for (const bool length : at.is_length) inertia_units.push_back(inertia_unit(length, length));
    text += numbers_line("decoupled there: u = k q'' (P1 eq. 27) with k  ", at.independent, *at.diagonal_factors,
                         inertia_units, units, with_units) +
            "\n";
  }
  if (at.split && view.shows(torques)) {
    text +=
        "torques and their parts\n" +
        numbers_line("  rates  ", at.independent, at.dq, list_units(at.is_length, "/s"), units, with_units) +
        numbers_line("  accelerations  ", at.independent, at.ddq, list_units(at.is_length, "/s^2"), units, with_units) +
        split_text(at, options) + "\n";
  }
  if (at.loops && view.shows(redundant)) text += redundant_text(at, options);
  if (at.natural) text += natural_text(*at.natural, options);
  if (at.regressor) text += regressor_text(at, options);
  if (at.parameters) text += parameters_text(at, units);
  for (const std::string& note : at.notes) text += "note: " + note + "\n";
  while (text.size() > 1 && text.ends_with("\n\n")) text.pop_back();
  return files::wrap_lines(text, options.width);
}

}  // namespace balance::reports
