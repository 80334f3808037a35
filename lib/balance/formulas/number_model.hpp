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
Vector3 values_of(const Vector3E& v);
Matrix3 values_of(const Matrix3E& m);

/// Symbols hold expressions over its graph: neither copied nor moved.
class NumberModel {
 public:
  NumberModel(const Mechanism& mechanism, const SpecTexts& texts);
  NumberModel(const NumberModel&) = delete;
  NumberModel& operator=(const NumberModel&) = delete;

  const MechanismOf<Expression>& mechanism() const { return mechanism_; }
  const std::vector<NamedExpression>& parameters() const { return parameters_; }
  /// As the spec has them, in its units: parameters that are no expressions, and free numbers.
  const std::vector<double>& inputs() const { return inputs_; }

  /// The value of every node where the inputs have other values.
  std::vector<double> nodes_at(const std::vector<double>& inputs) const;
  static double value(const Expression& x, const std::vector<double>& nodes) {
    return x.is_constant() ? x.value() : nodes[static_cast<std::size_t>(x.node())];
  }
  Mechanism mechanism_at(const std::vector<double>& nodes) const;

  /// Its value where every input is another number. What is equal here and at the spec's numbers is so for a reason.
  double elsewhere(const Expression& x) const;
  bool is_zero(const Expression& x) const { return x.value() == 0 && elsewhere(x) == 0; }
  bool are_equal(const Vector3E& a, const Vector3E& b) const;

 private:
  ExpressionGraph graph_;
  MechanismOf<Expression> mechanism_;
  std::vector<NamedExpression> parameters_;
  std::vector<double> inputs_, others_;
  mutable std::vector<double> elsewhere_;  ///< per node so far
};

}  // namespace balance::formulas
