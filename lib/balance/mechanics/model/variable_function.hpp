#pragma once
/// Numbers that change along a motion by an expression of a spec: the value of a constraint on speeds, which depends on
/// time, and factors of speeds, which depend on joint coordinates.

#include <memory>
#include <span>
#include <vector>

namespace balance::expression {
class ExpressionGraph;
}

namespace balance::model {

/// A value and its derivative along a motion.
struct ValueAndRate {
  double value = 0, rate = 0;
};

/// f(variables; parameters) in SI units. Empty: there is no such function.
template <class T>
struct VariableFunctionOf {
  std::shared_ptr<const expression::ExpressionGraph> graph;  ///< its inputs are the variables, then the parameters
  int node = -1;                                             ///< of the graph, for the value
  std::vector<T> parameters;

  explicit operator bool() const { return graph != nullptr; }
  /// The same function with other numbers as parameters.
  template <class To, class Number>
  VariableFunctionOf<To> convert(const Number& number) const {
    VariableFunctionOf<To> converted{graph, node, {}};
    for (const T& parameter : parameters) converted.parameters.push_back(number(parameter));
    return converted;
  }
};

using VariableFunction = VariableFunctionOf<double>;

/// @param rates of the variables
ValueAndRate evaluate(const VariableFunction& function, std::span<const double> variables,
                      std::span<const double> rates);

/// A function of time. @param time [s] @return its value and its time derivative; zeros of an empty function
ValueAndRate evaluate_at_time(const VariableFunction& function, double time);

}  // namespace balance::model
