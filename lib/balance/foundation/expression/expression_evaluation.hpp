#pragma once
/// Evaluates a graph with other inputs over any scalar: doubles, dual numbers (foundation/base/dual.hpp), expressions
/// of another graph, or any other algebra of operations.

#include "balance/foundation/base/dual.hpp"
#include "balance/foundation/base/elementary.hpp"
#include "balance/foundation/expression/expression.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace balance::expression {

/// Ordinary arithmetic. T provides the arithmetic operators, `value_of` and `apply_chain_rule`
/// (foundation/base/dual.hpp). Branches depend on values only.
template <class T>
struct ScalarAlgebra {
  using Value = T;

  T constant(double value) const { return T(value); }
  T apply(const ExpressionNode& node, const T& a, const T& b, const T& c) const {
    using elementary::atan2;
    switch (node.operation) {
      case Operation::constant:
      case Operation::input: break;
      case Operation::alias: return a;
      case Operation::add: return a + b;
      case Operation::subtract: return a - b;
      case Operation::multiply: return a * b;
      case Operation::divide: return a / b;
      case Operation::negate: return -a;
      case Operation::power: return power(a, b);
      case Operation::atan2: return atan2(a, b);
      case Operation::minimum: return value_of(b) < value_of(a) ? b : a;
      case Operation::maximum: return value_of(a) < value_of(b) ? b : a;
      case Operation::less: return T(value_of(a) < value_of(b) ? 1.0 : 0.0);
      case Operation::less_equal: return T(value_of(a) <= value_of(b) ? 1.0 : 0.0);
      case Operation::equal: return T(value_of(a) == value_of(b) ? 1.0 : 0.0);
      case Operation::logical_and: return T(value_of(a) != 0 && value_of(b) != 0 ? 1.0 : 0.0);
      case Operation::logical_or: return T(value_of(a) != 0 || value_of(b) != 0 ? 1.0 : 0.0);
      case Operation::select: return value_of(a) != 0 ? b : c;
      case Operation::function: {
        const UnaryFunction& f = list_unary_functions()[static_cast<std::size_t>(node.function)];
        return apply_function(a, f.value(value_of(a)), f.derivative);
      }
    }
    return T(0.0);
  }

 private:
  /// A function's value with its derivatives by the chain rule.
  static T apply_function(const T& x, double value, double (*derivative)(double)) {
    if constexpr (std::is_same_v<T, double>)
      return value;
    else
      return apply_chain_rule(x, value, derivative(x.value));
  }
  static T power(const T& a, const T& b) {
    const double x = value_of(a), y = value_of(b), value = elementary::pow(x, y);
    if constexpr (std::is_same_v<T, double>) {
      return value;
    } else {
      // for a constant exponent, skip the derivative with respect to it: the logarithm of a negative base is undefined
      const double exponent_derivative = x > 0 ? value * elementary::log(x) : x == 0 ? 0 : NAN;
      const T base = apply_chain_rule(a, value, y == 0 ? 0 : y * elementary::pow(x, y - 1));
      return b == T(y) && is_fixed(b) ? base : base + apply_chain_rule(b, 0, exponent_derivative);
    }
  }
  static bool is_fixed(const T& x) {
    if constexpr (std::is_same_v<T, double>)
      return true;
    else
      return std::all_of(x.d.begin(), x.d.end(), [](double d) { return d == 0; });
  }
};

/// Writes the operations into another graph and folds constants.
template <>
struct ScalarAlgebra<Expression> {
  using Value = Expression;

  Expression constant(double value) const { return value; }
  Expression apply(const ExpressionNode& node, const Expression& a, const Expression& b, const Expression& c) const;
};

/// The values of all nodes for the given values of the inputs.
template <class Algebra>
std::vector<typename Algebra::Value> evaluate(const ExpressionGraph& graph,
                                              const std::vector<typename Algebra::Value>& inputs,
                                              const Algebra& algebra) {
  using Value = typename Algebra::Value;
  std::vector<Value> values;
  values.reserve(graph.nodes().size());
  const Value missing_argument = algebra.constant(0);
  for (const ExpressionNode& node : graph.nodes()) {
    const auto argument = [&](std::size_t i) -> const Value& {
      return node.arguments[i] < 0 ? missing_argument : values[static_cast<std::size_t>(node.arguments[i])];
    };
    if (node.operation == Operation::constant)
      values.push_back(algebra.constant(node.constant));
    else if (node.operation == Operation::input)
      values.push_back(inputs[static_cast<std::size_t>(node.input)]);
    else
      values.push_back(algebra.apply(node, argument(0), argument(1), argument(2)));
  }
  return values;
}

}  // namespace balance::expression
