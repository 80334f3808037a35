#include "balance/synthesis/verification/natural_terms.hpp"

#include "balance/synthesis/verification/natural_model.hpp"
#include "balance/synthesis/verification/natural_momentum.hpp"

#include <array>
#include <charconv>
#include <stdexcept>

namespace balance::verification::natural {

namespace {

std::string format_number(double value) {
  std::array<char, 32> text{};
  const auto [end, error] = std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::general, 6);
  return {text.data(), end};
}

std::string weight_text(Complex weight) {
  if (weight.imag() == 0) return format_number(weight.real());
  if (weight.real() == 0) return format_number(weight.imag()) + "i";
  return "(" + format_number(weight.real()) + (weight.imag() < 0 ? " - " : " + ") +
         format_number(std::abs(weight.imag())) + "i)";
}

/// Adds a term with its sign in front.
void append_term(std::string& text, Complex weight, const std::string& name) {
  const bool minus = weight.imag() == 0 && weight.real() < 0;
  if (minus) weight = -weight;
  text += text.empty() ? (minus ? "-" : "") : minus ? " - " : " + ";
  if (name.empty() || weight != Complex(1)) text += weight_text(weight);
  if (!name.empty()) text += (weight != Complex(1) ? " " : "") + name;
}

std::string form_text(const AffineForm& form, const std::vector<std::string>& points) {
  std::string text;
  for (const PointTerm& term : form.terms)
    if (term.weight != Complex(0)) append_term(text, term.weight, points[static_cast<std::size_t>(term.point)]);
  if (form.constant != Complex(0) || text.empty()) append_term(text, form.constant, "");
  return text;
}

bool is_same_form(const AffineForm& a, const AffineForm& b) {
  if (a.constant != b.constant || a.terms.size() != b.terms.size()) return false;
  for (std::size_t i = 0; i < a.terms.size(); ++i)
    if (a.terms[i].point != b.terms[i].point || a.terms[i].weight != b.terms[i].weight) return false;
  return true;
}

/// Points are complex numbers; a·b is Re(conj(a) b).
std::string row_text(const ConstraintRow& row, const std::vector<std::string>& points,
                     const std::vector<std::string>& scalars) {
  std::string text;
  if (row.angle >= 0) {
    text = "Im(exp(-i " + scalars[static_cast<std::size_t>(row.angle)] + ") (" + form_text(row.right, points) + "))";
  } else {
    const bool has_product = !row.right.terms.empty() || row.right.constant != Complex(0);
    const bool is_unit = row.left.terms.empty() && row.left.constant == Complex(1);
    if (has_product && is_same_form(row.left, row.right))
      text = "|" + form_text(row.right, points) + "|^2";
    else if (has_product && is_unit)
      text = "Re(" + form_text(row.right, points) + ")";
    else if (has_product)
      text = "(" + form_text(row.left, points) + ")·(" + form_text(row.right, points) + ")";
    for (const ScalarTerm& term : row.scalars)
      append_term(text, term.coefficient, scalars[static_cast<std::size_t>(term.scalar)]);
  }
  return text + " = " + format_number(row.angle >= 0 ? 0 : row.constant);
}

std::string rotor_text(const Rotor& rotor, double length, const std::vector<std::string>& scalars) {
  std::string angle_text;
  for (const ScalarTerm& term : rotor.angle.terms)
    append_term(angle_text, term.coefficient, scalars[static_cast<std::size_t>(term.scalar)]);
  return format_number(rotor.inertia * length * length) + " kg m^2 turning by " +
         (angle_text.empty() ? "0" : angle_text);
}

MatrixX mass_matrix(const NaturalModel& model) {
  const Eigen::Index p = model.basic.count();
  MatrixX M = MatrixX::Zero(2 * p, 2 * p);
  for (const MassEntry& entry : model.mass) {
    const double re = entry.value.real(), im = entry.value.imag();
    M.block<2, 2>(2 * entry.row, 2 * entry.column) += (Eigen::Matrix2d() << re, -im, im, re).finished();
  }
  return M;
}

}  // namespace

NaturalTerms compute_natural_terms(const Mechanism& mechanism, const VectorX& coordinates) {
  if (mechanism.space != SpaceKind::planar)
    throw std::invalid_argument("natural coordinates are for planar mechanisms");
  if (coordinates.size() != static_cast<Eigen::Index>(mechanism.coordinates.size()))
    throw std::invalid_argument("coordinates: expected as many values as the mechanism has coordinates");
  const NaturalModel model =
      build_model(mechanism, {}, false, {std::vector<double>(coordinates.begin(), coordinates.end()), 0});
  NaturalTerms result;
  result.points = model.basic.names;
  result.moving = model.basic.moving;
  result.unit = model.length();
  result.total_mass = model.total_mass;
  result.mass = mass_matrix(model);
  std::vector<std::string> scalars;
  for (int s = 0; s < model.scalars; ++s) scalars.push_back("s" + std::to_string(s + 1));
  for (std::size_t b = 0; b < model.bodies.size(); ++b)
    if (model.bodies[b].angle >= 0)
      scalars[static_cast<std::size_t>(model.bodies[b].angle)] = "angle(" + mechanism.bodies[b].name + ")";
  for (Eigen::Index m = 0; m < result.moving; ++m)
    for (const char* axis : {".x", ".y"})
      result.coordinates.push_back(result.points[static_cast<std::size_t>(m)] + axis);
  result.coordinates.insert(result.coordinates.end(), scalars.begin(), scalars.end());
  result.position.resize(model.basic.count(), 2);
  for (int m = 0; m < model.basic.count(); ++m) {
    const Complex z = model.start.points[static_cast<std::size_t>(m)] * model.length();
    result.position.row(m) << z.real(), z.imag();
  }
  for (const Rotor& rotor : model.rotors) result.rotors.push_back(rotor_text(rotor, model.length(), scalars));
  const auto rows = static_cast<Eigen::Index>(model.constraints.size());
  result.residual.resize(rows);
  result.jacobian.resize(rows, model.unknowns());
  for (Eigen::Index r = 0; r < rows; ++r) {
    const ConstraintRow& row = model.constraints[static_cast<std::size_t>(r)];
    result.constraints.push_back(row_text(row, result.points, scalars));
    result.residual[r] = row.value(model.start);
    Eigen::RowVectorXd gradient(model.unknowns());
    row.gradient(model.start, model.basic.moving, gradient);
    result.jacobian.row(r) = gradient;
  }
  for (const PointCoefficient& coefficient : point_coefficients(mechanism))
    result.coefficients.push_back({coefficient.point, coefficient.fixed, coefficient.coefficient});
  return result;
}

}  // namespace balance::verification::natural
