#pragma once
/// A number that remembers what it is made of: arithmetic on expressions gives their present values at once and writes the
/// operations into a graph, which can be evaluated again with other inputs (expression/evaluation.hpp).

#include "balance/base/types.hpp"
#include "balance/expression/graph.hpp"

#include <initializer_list>

namespace balance {

/// A constant, or a node of a graph with its present value. The graph must outlive arithmetic on it. What is made of constants, of
/// a factor zero or of neutral elements alone gets no node.
class Expression {
 public:
  Expression() = default;
  Expression(double constant) : value_(constant) {}  // NOLINT(google-explicit-constructor): a constant is a number, too
  /// A new input with its present value.
  static Expression input(ExpressionGraph& graph, double value) { return {value, graph.add_input(), &graph}; }
  /// The same number under a name of its own: another node.
  static Expression make_alias(ExpressionGraph& graph, const Expression& x);

  double value() const { return value_; }
  bool is_constant() const { return node_ < 0; }
  /// −1: a constant
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

  /// @param value what the operation gives at present
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
// What branches: comparisons that the graph makes again, not ones of present values.
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

}  // namespace balance

/// So that vectors and matrices may have such entries.
template <>
struct Eigen::NumTraits<balance::Expression> : Eigen::NumTraits<double> {
  using Real = balance::Expression;
  using NonInteger = balance::Expression;
  using Nested = balance::Expression;
  using Literal = double;
  enum { RequireInitialization = 1, ReadCost = 1, AddCost = 10, MulCost = 10 };
};
