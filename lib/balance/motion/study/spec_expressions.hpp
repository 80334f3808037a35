#pragma once
/// A spec as expressions: every number of the mechanism and of the trajectories as a function of the spec's parameters
/// and free numbers. It can be evaluated for other values without reading the spec again.

#include "balance/foundation/expression/expression_evaluation.hpp"
#include "balance/mechanics/model/mechanism_conversion.hpp"
#include "balance/mechanics/trajectory/trajectory_conversion.hpp"

#include <map>
#include <memory>
#include <string>
#include <vector>

namespace balance::study {

/// A parameter of the spec, in the spec's units.
struct NamedExpression {
  std::string name;
  Expression value;
  bool is_plain = false;  ///< a number or a free number; otherwise an expression of others
};

struct Recording {
  expression::ExpressionGraph graph;
  std::vector<double> inputs;  ///< values as read
  std::vector<int> free;       ///< the input of each free number of the study
  std::vector<NamedExpression> parameters;
  MechanismOf<Expression> mechanism;
  std::vector<TrajectoryOf<Expression>> trajectories;
  std::vector<Expression> toleranced;  ///< numbers named in `tolerances`

  /// The input that an expression is. @param input made by Expression::input
  int input_index(const Expression& input) const { return graph.nodes()[static_cast<std::size_t>(input.node())].input; }
};

/// Values of all expressions of a recording for given inputs.
template <class T>
class RecordedValues {
 public:
  RecordedValues(const Recording& recording, const std::vector<T>& inputs)
      : recording_(recording), values_(evaluate(recording.graph, inputs, expression::ScalarAlgebra<T>())) {}

  T operator()(const Expression& expression) const {
    return expression.is_constant() ? T(expression.value()) : values_[static_cast<std::size_t>(expression.node())];
  }

  MechanismOf<T> mechanism() const { return model::convert_mechanism<T>(recording_.mechanism, *this); }
  std::vector<TrajectoryOf<T>> trajectories() const {
    std::vector<TrajectoryOf<T>> result;
    for (const auto& trajectory : recording_.trajectories)
      result.push_back(trajectory::cast_scalar<T>(trajectory, *this));
    return result;
  }

 private:
  const Recording& recording_;
  std::vector<T> values_;
};

/// A parameter as written in the spec. Formulas take names of parameters and the composition of numbers from it.
struct ParameterText {
  std::string name;
  std::string text;  ///< a number or an expression of other parameters; for a free one, its start value
};

/// Numbers as written in the spec; empty for a mechanism without a spec.
struct SpecNumberTexts {
  std::vector<ParameterText> parameters;       ///< in the document's order
  std::map<std::string, std::string> numbers;  ///< scalars by key path, `bodies.link1.com[0]`
  std::shared_ptr<const Recording> recording;  ///< null: all numbers are constant
};

// A mechanism as a function of numbers, for its values and derivatives.

/// Copies share the graph, which is not modified any more.
struct ParametricMechanism {
  std::shared_ptr<const expression::ExpressionGraph> graph;  ///< its inputs are the numbers; null: there are none
  MechanismOf<Expression> mechanism;

  int size() const { return graph ? graph->inputs() : 0; }

  /// Expressed in another graph.
  MechanismOf<Expression> over(const std::vector<Expression>& numbers) const { return evaluate<Expression>(numbers); }
  /// @param numbers doubles or dual numbers, as many as size()
  template <class T>
  MechanismOf<T> evaluate(const std::vector<T>& numbers) const {
    std::vector<T> values;
    if (graph) values = expression::evaluate(*graph, numbers, expression::ScalarAlgebra<T>());
    return model::convert_mechanism<T>(mechanism, [&](const Expression& x) {
      return x.is_constant() ? T(x.value()) : values[static_cast<std::size_t>(x.node())];
    });
  }
};

/// Builds it from inputs 0 … size − 1 of a new graph, whose values are `start`.
/// @param build const std::vector<Expression>& → MechanismOf<Expression>
template <class Build>
ParametricMechanism make_parametric_mechanism(const VectorX& start, const Build& build) {
  const auto graph = std::make_shared<expression::ExpressionGraph>();
  std::vector<Expression> numbers;
  for (const double value : start) numbers.push_back(Expression::input(*graph, value));
  ParametricMechanism result;
  result.mechanism = build(numbers);
  result.graph = graph;
  return result;
}

}  // namespace balance::study
