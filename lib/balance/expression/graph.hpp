#pragma once
/// Expressions as a graph: every operation once, after what it is made of. Plain values; a graph only grows.

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace balance {

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

}  // namespace balance
