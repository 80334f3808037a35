#include "balance/formulas/number_model.hpp"

#include <cmath>

namespace balance::formulas {

bool is_constant(const Vector3E& v) {
  return std::all_of(v.begin(), v.end(), [](const Expression& x) { return x.is_constant(); });
}

bool is_constant(const Matrix3E& m) {
  return is_constant(Vector3E(m.col(0))) && is_constant(Vector3E(m.col(1))) && is_constant(Vector3E(m.col(2)));
}

Vector3 to_values(const Vector3E& v) { return {v[0].value(), v[1].value(), v[2].value()}; }

Matrix3 to_values(const Matrix3E& m) {
  Matrix3 values;
  for (int column = 0; column < 3; ++column) values.col(column) = to_values(Vector3E(m.col(column)));
  return values;
}

ParametricModel::ParametricModel(const Mechanism& mechanism, const SpecNumberTexts& texts) {
  if (texts.recording == nullptr) {
    mechanism_ = convert_mechanism<Expression>(mechanism, [](double x) { return Expression(x); });
    return;
  }
  inputs_ = texts.recording->inputs;
  std::vector<Expression> inputs;
  for (const double value : inputs_) inputs.push_back(Expression::input(graph_, value));
  const RecordedValues<Expression> recorded(*texts.recording, inputs);
  mechanism_ = recorded.mechanism();
  for (const NamedExpression& parameter : texts.recording->parameters)
    parameters_.push_back({parameter.name, recorded(parameter.value), parameter.is_plain});
  // factors between 1.1 and 1.3 that nothing else has
  double turn = 0;
  for (const double value : inputs_) {
    turn = std::fmod(turn + 0.6180339887498949, 1.0);
    perturbed_inputs_.push_back(value == 0 ? 0.1 + 0.2 * turn : value * (1.1 + 0.2 * turn));
  }
}

std::vector<double> ParametricModel::evaluate_nodes(const std::vector<double>& inputs) const {
  return evaluate(graph_, inputs, ScalarAlgebra<double>());
}

Mechanism ParametricModel::build_mechanism(const std::vector<double>& nodes) const {
  return convert_mechanism<double>(mechanism_, [&](const Expression& x) { return node_value(x, nodes); });
}

double ParametricModel::perturbed_value(const Expression& x) const {
  if (!x.is_constant() && static_cast<std::size_t>(x.node()) >= perturbed_nodes_.size())
    perturbed_nodes_ = evaluate_nodes(perturbed_inputs_);
  return node_value(x, perturbed_nodes_);
}

bool ParametricModel::are_equal(const Vector3E& a, const Vector3E& b) const {
  for (int k = 0; k < 3; ++k)
    if (a[k].value() != b[k].value() || perturbed_value(a[k]) != perturbed_value(b[k])) return false;
  return true;
}

}  // namespace balance::formulas
