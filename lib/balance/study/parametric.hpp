#pragma once
/// A mechanism that depends on numbers, as expressions: what it is at other numbers, and how it depends on them.

#include "balance/expression/evaluation.hpp"
#include "balance/model/conversion.hpp"

#include <memory>
#include <vector>

namespace balance {

/// A copy shares its graph, which does not change any more.
struct ParametricMechanism {
  std::shared_ptr<const ExpressionGraph> graph;  ///< its inputs are the numbers; null: there are none
  MechanismOf<Expression> mechanism;

  int size() const { return graph ? graph->inputs() : 0; }

  /// Written into another graph.
  MechanismOf<Expression> over(const std::vector<Expression>& numbers) const { return evaluate<Expression>(numbers); }
  /// @param numbers doubles or numbers with derivatives, as many as size()
  template <class T>
  MechanismOf<T> evaluate(const std::vector<T>& numbers) const {
    std::vector<T> values;
    if (graph) values = balance::evaluate(*graph, numbers, ScalarAlgebra<T>());
    return convert_mechanism<T>(mechanism, [&](const Expression& x) {
      return x.is_constant() ? T(x.value()) : values[static_cast<std::size_t>(x.node())];
    });
  }
};

/// Built from inputs 0 … size − 1 of a new graph, whose present values are `start`.
/// @param build const std::vector<Expression>& → MechanismOf<Expression>
template <class Build>
ParametricMechanism make_parametric_mechanism(const VectorX& start, const Build& build) {
  const auto graph = std::make_shared<ExpressionGraph>();
  std::vector<Expression> numbers;
  for (const double value : start) numbers.push_back(Expression::input(*graph, value));
  ParametricMechanism result;
  result.mechanism = build(numbers);
  result.graph = graph;
  return result;
}

}  // namespace balance
