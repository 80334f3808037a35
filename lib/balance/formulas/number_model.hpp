#pragma once
/// A mechanism's numbers as expressions over what its spec lets one change: parameters and free numbers. Private to formulas.

#include "balance/expression/evaluation.hpp"
#include "balance/model/conversion.hpp"
#include "balance/study/spec_texts.hpp"

#include <vector>

namespace balance::formulas {

using Vector3E = Vector3Of<Expression>;
using Matrix3E = Matrix3Of<Expression>;

bool is_constant(const Vector3E& v);
bool is_constant(const Matrix3E& m);
Vector3 to_values(const Vector3E& v);
Matrix3 to_values(const Matrix3E& m);

/// Symbols hold expressions over its graph: neither copied nor moved.
class ParametricModel {
 public:
  ParametricModel(const Mechanism& mechanism, const SpecNumberTexts& texts);
  ParametricModel(const ParametricModel&) = delete;
  ParametricModel& operator=(const ParametricModel&) = delete;

  const MechanismOf<Expression>& mechanism() const { return mechanism_; }
  const std::vector<NamedExpression>& parameters() const { return parameters_; }
  /// As the spec has them, in its units: parameters that are no expressions, and free numbers.
  const std::vector<double>& inputs() const { return inputs_; }

  /// The value of every node where the inputs have other values.
  std::vector<double> evaluate_nodes(const std::vector<double>& inputs) const;
  static double node_value(const Expression& x, const std::vector<double>& nodes) {
    return x.is_constant() ? x.value() : nodes[static_cast<std::size_t>(x.node())];
  }
  Mechanism build_mechanism(const std::vector<double>& nodes) const;

  /// Its value where every input is another number. What is equal here and at the spec's numbers is so for a reason.
  double perturbed_value(const Expression& x) const;
  bool is_zero(const Expression& x) const { return x.value() == 0 && perturbed_value(x) == 0; }
  bool are_equal(const Vector3E& a, const Vector3E& b) const;

 private:
  ExpressionGraph graph_;
  MechanismOf<Expression> mechanism_;
  std::vector<NamedExpression> parameters_;
  std::vector<double> inputs_, perturbed_inputs_;
  mutable std::vector<double> perturbed_nodes_;  ///< per node so far
};

}  // namespace balance::formulas
