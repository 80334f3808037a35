#pragma once
/// A number that remembers what it is made of: arithmetic on expressions gives their present values at once and writes the
/// operations into a graph, which can be evaluated again with other inputs (foundation/expression/expression_evaluation.hpp).

#include "balance/foundation/base/types.hpp"

#include <array>
#include <cstdint>
#include <initializer_list>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace balance {

/// Expressions as a graph: every operation once, after what it is made of. Plain values; a graph only grows.
enum class Operation : std::uint8_t {
  constant,
  input,  ///< a number that may change
  alias,  ///< the same as its argument: where a parameter gives it a name of its own
  add,
  subtract,
  multiply,
  divide,
  negate,
  power,
  atan2,
  minimum,
  maximum,
  less,  ///< 1 or 0, like all that follow but `choose`
  less_equal,
  equal,
  logical_and,
  logical_or,
  select,    ///< the second argument where the first is not zero, else the third
  function,  ///< of one argument
};

/// A function of one argument with its derivative. Undefined values are NaN.
struct UnaryFunction {
  std::string_view name;  ///< as in specs
  double (*value)(double);
  double (*derivative)(double);
};
std::span<const UnaryFunction> list_unary_functions();
/// Index of the function of that name, which must exist.
int find_unary_function(std::string_view name);

struct ExpressionNode {
  Operation operation = Operation::constant;
  int function = 0;                             ///< into list_unary_functions()
  std::array<int, 3> arguments = {-1, -1, -1};  ///< nodes, all of them earlier ones
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
