#pragma once
/// A number that records how it was computed: arithmetic on expressions yields their current values at once and also
/// records the operations in a graph, which can be evaluated again with other inputs
/// (foundation/expression/expression_evaluation.hpp).

#include "balance/foundation/base/types.hpp"

#include <array>
#include <cstdint>
#include <initializer_list>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace balance::expression {

/// Operation of a node in an expression graph. Nodes come after their arguments; a graph only grows.
enum class Operation : std::uint8_t {
  constant,
  input,  ///< a number that may change
  alias,  ///< equal to its argument: gives a parameter a node of its own
  add,
  subtract,
  multiply,
  divide,
  negate,
  power,
  atan2,
  minimum,
  maximum,
  less,  ///< this and the following four yield 1 or 0
  less_equal,
  equal,
  logical_and,
  logical_or,
  select,    ///< the second argument if the first is not zero, otherwise the third
  function,  ///< of one argument
};

/// A function of one argument with its derivative. Undefined values are NaN.
struct UnaryFunction {
  std::string_view name;  ///< as in specs
  double (*value)(double);
  double (*derivative)(double);
};
std::span<const UnaryFunction> list_unary_functions();
/// Index of the function with that name; list_unary_functions().size() if there is none.
int find_unary_function(std::string_view name);

struct ExpressionNode {
  Operation operation = Operation::constant;
  int function = 0;                             ///< index into list_unary_functions()
  std::array<int, 3> arguments = {-1, -1, -1};  ///< indices of earlier nodes
  double constant = 0;
  int input = -1;
};

class ExpressionGraph {
 public:
  /// @return the node's index
  int add(const ExpressionNode& node) {
    nodes_.push_back(node);
    return static_cast<int>(nodes_.size()) - 1;
  }
  int add_input() { return add({.operation = Operation::input, .input = inputs_++}); }
  int inputs() const { return inputs_; }
  const std::vector<ExpressionNode>& nodes() const { return nodes_; }

 private:
  std::vector<ExpressionNode> nodes_;
  int inputs_ = 0;
};

/// A constant, or a node of a graph with its current value. The graph must outlive arithmetic on it. Operations on
/// constants alone, multiplication by zero and operations with a neutral element create no node.
class Expression {
 public:
  Expression() = default;
  Expression(double constant) : value_(constant) {}  // NOLINT(google-explicit-constructor): plain numbers are constants
  /// A new input with its current value.
  static Expression input(ExpressionGraph& graph, double value) { return {value, graph.add_input(), &graph}; }
  /// The same number as a separate node.
  static Expression make_alias(ExpressionGraph& graph, const Expression& x);

  double value() const { return value_; }
  bool is_constant() const { return node_ < 0; }
  /// −1 for a constant.
  int node() const { return node_; }

  friend Expression operator+(const Expression& a, const Expression& b);
  friend Expression operator-(const Expression& a, const Expression& b);
  friend Expression operator*(const Expression& a, const Expression& b);
  friend Expression operator/(const Expression& a, const Expression& b);
  friend Expression operator-(const Expression& a);
  Expression& operator+=(const Expression& b) { return *this = *this + b; }
  Expression& operator-=(const Expression& b) { return *this = *this - b; }
  Expression& operator*=(const Expression& b) { return *this = *this * b; }
  Expression& operator/=(const Expression& b) { return *this = *this / b; }

  /// @param value result of the operation for the current inputs
  static Expression make_node(Operation operation, double value, std::initializer_list<const Expression*> arguments,
                              int function = 0);

 private:
  Expression(double value, int node, ExpressionGraph* graph) : value_(value), node_(node), graph_(graph) {}

  double value_ = 0;
  int node_ = -1;
  ExpressionGraph* graph_ = nullptr;
};

Expression power(const Expression& base, const Expression& exponent);
Expression atan2(const Expression& y, const Expression& x);
Expression minimum(const Expression& a, const Expression& b);
Expression maximum(const Expression& a, const Expression& b);
// Comparisons and branches that the graph evaluates again, unlike comparisons of current values.
Expression less(const Expression& a, const Expression& b);
Expression less_equal(const Expression& a, const Expression& b);
Expression equal(const Expression& a, const Expression& b);
Expression logical_and(const Expression& a, const Expression& b);
Expression logical_or(const Expression& a, const Expression& b);
Expression select(const Expression& condition, const Expression& yes, const Expression& no);
/// @param function index into list_unary_functions()
Expression apply(int function, const Expression& x);
Expression sin(const Expression& x);
Expression cos(const Expression& x);
Expression sqrt(const Expression& x);
Expression abs(const Expression& x);

}  // namespace balance::expression

namespace balance {

using expression::Expression;

}  // namespace balance

/// Lets Eigen vectors and matrices hold expressions.
template <>
struct Eigen::NumTraits<balance::Expression> : Eigen::NumTraits<double> {
  using Real = balance::Expression;
  using NonInteger = balance::Expression;
  using Nested = balance::Expression;
  using Literal = double;
  enum { RequireInitialization = 1, ReadCost = 1, AddCost = 10, MulCost = 10 };
};
