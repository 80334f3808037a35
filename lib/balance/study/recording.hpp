#pragma once
/// What a spec says as expressions: every number of the mechanism and of the trajectories over the spec's parameters and free
/// numbers. Nothing is read again to know it with other values.

#include "balance/expression/evaluation.hpp"
#include "balance/model/conversion.hpp"
#include "balance/motion/trajectory_conversion.hpp"

#include <string>
#include <vector>

namespace balance {

/// A parameter of the spec, in the spec's units.
struct NamedExpression {
  std::string name;
  Expression value;
  bool is_plain = false;  ///< a number or free; otherwise an expression over others
};

struct Recording {
  ExpressionGraph graph;
  std::vector<double> inputs;  ///< their values as read
  std::vector<int> free;       ///< per free number of the study: its input
  std::vector<NamedExpression> parameters;
  MechanismOf<Expression> mechanism;
  std::vector<TrajectoryOf<Expression>> trajectories;
  std::vector<Expression> toleranced;  ///< numbers that may be off: what `tolerances` names

  /// The input that an expression is. @param input one made by Expression::input
  int input_index(const Expression& input) const { return graph.nodes()[static_cast<std::size_t>(input.node())].input; }
};

/// All expressions of a recording at values of its inputs.
template <class T>
class RecordedValues {
 public:
  RecordedValues(const Recording& recording, const std::vector<T>& inputs)
      : recording_(recording), values_(evaluate(recording.graph, inputs, ScalarAlgebra<T>())) {}

  T operator()(const Expression& expression) const {
    return expression.is_constant() ? T(expression.value()) : values_[static_cast<std::size_t>(expression.node())];
  }

  MechanismOf<T> mechanism() const { return convert_mechanism<T>(recording_.mechanism, *this); }
  std::vector<TrajectoryOf<T>> trajectories() const {
    std::vector<TrajectoryOf<T>> all;
    for (const auto& trajectory : recording_.trajectories) all.push_back(cast_scalar<T>(trajectory, *this));
    return all;
  }

 private:
  const Recording& recording_;
  std::vector<T> values_;
};

}  // namespace balance
