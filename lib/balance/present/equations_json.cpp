#include "balance/present/equations_view.hpp"
#include "balance/write/json_parts.hpp"

namespace balance {

namespace {

Json matrix_json(const MatrixX& matrix) {
  Json rows = Json::array();
  for (Eigen::Index r = 0; r < matrix.rows(); ++r) rows.push_back(numbers_json(matrix.row(r).transpose()));
  return rows;
}

Json forms_json(const std::vector<MatrixX>& forms) {
  Json all = Json::array();
  for (const MatrixX& form : forms) all.push_back(matrix_json(form));
  return all;
}

Json rest_json(const StaticTerms& rest) {
  return {{"sum", numbers_json(rest.sum())},
          {"weight", numbers_json(rest.weight)},
          {"springs", numbers_json(rest.springs)},
          {"loads", numbers_json(rest.loads)}};
}

Json named_json(const std::vector<std::string>& names, const VectorX& values) {
  Json json = Json::object();
  for (std::size_t k = 0; k < names.size(); ++k) json[names[k]] = values[static_cast<Eigen::Index>(k)];
  return json;
}

Json split_json(const EquationsAtConfiguration& at) {
  Json json = Json::object();
  for (std::size_t a = 0; a < at.actuators.size(); ++a) {
    const auto row = static_cast<Eigen::Index>(a);
    Json parts = Json::object();
    for (std::size_t p = 0; p < effort_part_names.size(); ++p)
      parts[effort_part_names[p]] = at.split->parts(row, static_cast<Eigen::Index>(p));
    parts["sum"] = at.split->effort[row];
    parts["unit"] = force_unit(at.is_force[a]);
    json[at.actuators[a]] = parts;
  }
  return json;
}

Json terms_json(const IndependentTerms& terms) {
  return {{"M", matrix_json(terms.mass)},
          {"D", forms_json(terms.velocity)},
          {"B", matrix_json(terms.viscous)},
          {"z", rest_json(terms.static_terms)},
          {"input", matrix_json(terms.input)}};
}

Json speeds_json(const EquationsAtConfiguration& at) {
  Json json = terms_json(at.in_speeds->speed_equations);
  json["speeds"] = at.speeds;
  json["rows"] = matrix_json(at.in_speeds->rows);
  json["rates"] = matrix_json(at.in_speeds->rates);
  json["constraints"] = at.zero;
  json["freedoms"] = {{"configuration", at.independent.size()}, {"velocity", at.speeds.size()}};
  json["held"] = terms_json(at.in_speeds->constraint_equations);
  return json;
}

Json redundant_json(const EquationsAtConfiguration& at) {
  const RedundantTerms& loops = *at.loops;
  return {{"coordinates", at.redundant},
          {"closures", at.closures},
          {"M", matrix_json(loops.mass)},
          {"D", forms_json(loops.velocity)},
          {"B", matrix_json(loops.viscous)},
          {"z", rest_json(loops.rest)},
          {"S", matrix_json(loops.input)},
          {"A", matrix_json(loops.constraints)},
          {"C", matrix_json(loops.transformation)},
          {"c", forms_json(loops.acceleration)}};
}

Json natural_json(const natural::NaturalTerms& n) {
  Json json = {{"points", n.points},
               {"moving", n.moving},
               {"coordinates", n.coordinates},
               {"position", matrix_json(n.position)},
               {"M", matrix_json(n.mass)},
               {"discs", n.rotors},
               {"unit", n.unit},
               {"constraints", n.constraints},
               {"residual", numbers_json(n.residual)},
               {"J", matrix_json(n.jacobian)},
               {"total_mass", n.total_mass}};
  json["C_P"] = Json::object();
  for (const natural::PointMatrix& one : n.coefficients) {
    const double re = one.coefficient.real(), im = one.coefficient.imag();
    json["C_P"][one.point] = {{re, -im}, {im, re}};
  }
  return json;
}

Json regressor_json(const EffortRegressor& regressor) {
  std::vector<std::string> names;
  for (const Parameter& p : regressor.parameters) names.push_back(p.name);
  return {{"parameters", names},
          {"values", numbers_json(regressor.values)},
          {"effort", matrix_json(regressor.effort)},
          {"shaking_force", matrix_json(regressor.shaking_force)},
          {"shaking_moment", matrix_json(regressor.shaking_moment)},
          {"other", numbers_json(regressor.constant_effort)}};
}

Json parameters_json(const EquationsAtConfiguration& at) {
  const Conditions& c = *at.parameters;
  std::vector<std::string> names, texts;
  for (const Parameter& p : c.parameters) names.push_back(p.name);
  for (int row = 0; row < c.rank; ++row) texts.push_back(base_parameter_text(c, row, at.parameter_names));
  return {{"rank", c.rank},        {"gap", c.singular_value_gap}, {"parameters", names},
          {"combinations", texts}, {"pivots", c.pivots},          {"matrix", matrix_json(c.matrix)}};
}

}  // namespace

std::string equations_json(const EquationsReportData& view, const std::vector<std::string>& warnings) {
  using enum EquationSection;
  const EquationsAtConfiguration& at = view.at;
  Json json = {{"mechanism", view.title},
               {"configuration", named_json(view.coordinates, at.configuration)},
               {"independent", at.independent},
               {"actuators", at.actuators},
               {"q", numbers_json(at.q)},
               {"rates", numbers_json(at.dq)},
               {"accelerations", numbers_json(at.ddq)}};
  if (view.shows(inertia)) json["M"] = matrix_json(at.terms->mass);
  if (view.shows(inertia)) json["input"] = matrix_json(at.terms->input);
  if (view.shows(velocity)) json["D"] = forms_json(at.terms->velocity);
  if (view.shows(velocity)) json["B"] = matrix_json(at.terms->viscous);
  if (view.shows(gravity)) json["z"] = rest_json(at.terms->static_terms);
  if (at.in_speeds) json["in_speeds"] = speeds_json(at);
  if (at.diagonal_factors) json["k"] = numbers_json(*at.diagonal_factors);
  if (at.split && view.shows(torques)) json["torques"] = split_json(at);
  if (at.loops && view.shows(redundant)) json["redundant"] = redundant_json(at);
  if (at.natural) json["natural"] = natural_json(*at.natural);
  if (at.regressor) json["regressor"] = regressor_json(*at.regressor);
  if (at.parameters) json["base_parameters"] = parameters_json(at);
  json["notes"] = at.notes;
  json["warnings"] = warnings;
  return format_json(json);
}

}  // namespace balance
