#include "balance/foundation/expression/expression.hpp"

#include "balance/foundation/base/elementary.hpp"
#include "balance/foundation/expression/expression_evaluation.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace balance::expression {

Expression Expression::make_node(Operation operation, double value, std::initializer_list<const Expression*> arguments,
                                 int function) {
  ExpressionGraph* graph = nullptr;
  for (const Expression* argument : arguments)
    if (!argument->is_constant()) graph = argument->graph_;
  if (graph == nullptr) return value;
  ExpressionNode node{.operation = operation, .function = function};
  std::size_t i = 0;
  for (const Expression* argument : arguments)
    node.arguments[i++] = argument->is_constant() ? graph->add({.constant = argument->value_}) : argument->node_;
  return {value, graph->add(node), graph};
}

namespace {

bool is_constant_value(const Expression& x, double value) { return x.is_constant() && x.value() == value; }
/// Neutral elements are dropped next to a variable operand. Two constants are summed, which gives a zero its proper
/// sign.
bool both_constant(const Expression& a, const Expression& b) { return a.is_constant() && b.is_constant(); }

}  // namespace

Expression Expression::make_alias(ExpressionGraph& graph, const Expression& x) {
  const int argument = x.is_constant() ? graph.add({.constant = x.value_}) : x.node_;
  return {x.value_, graph.add({.operation = Operation::alias, .arguments = {argument, -1, -1}}), &graph};
}

Expression operator+(const Expression& a, const Expression& b) {
  if (both_constant(a, b)) return a.value_ + b.value_;
  if (is_constant_value(a, 0)) return b;
  if (is_constant_value(b, 0)) return a;
  return Expression::make_node(Operation::add, a.value_ + b.value_, {&a, &b});
}

Expression operator-(const Expression& a, const Expression& b) {
  if (both_constant(a, b)) return a.value_ - b.value_;
  if (is_constant_value(a, 0)) return -b;
  if (is_constant_value(b, 0)) return a;
  return Expression::make_node(Operation::subtract, a.value_ - b.value_, {&a, &b});
}

Expression operator*(const Expression& a, const Expression& b) {
  if (is_constant_value(a, 1)) return b;
  if (is_constant_value(b, 1)) return a;
  if (is_constant_value(a, 0) || is_constant_value(b, 0)) return a.value_ * b.value_;
  return Expression::make_node(Operation::multiply, a.value_ * b.value_, {&a, &b});
}

Expression operator/(const Expression& a, const Expression& b) {
  if (is_constant_value(b, 1)) return a;
  return Expression::make_node(Operation::divide, a.value_ / b.value_, {&a, &b});
}

Expression operator-(const Expression& a) { return Expression::make_node(Operation::negate, -a.value_, {&a}); }

Expression power(const Expression& base, const Expression& exponent) {
  if (is_constant_value(exponent, 1)) return base;
  return Expression::make_node(Operation::power, elementary::pow(base.value(), exponent.value()), {&base, &exponent});
}

Expression atan2(const Expression& y, const Expression& x) {
  return Expression::make_node(Operation::atan2, elementary::atan2(y.value(), x.value()), {&y, &x});
}

Expression minimum(const Expression& a, const Expression& b) {
  return Expression::make_node(Operation::minimum, std::min(a.value(), b.value()), {&a, &b});
}

Expression maximum(const Expression& a, const Expression& b) {
  return Expression::make_node(Operation::maximum, std::max(a.value(), b.value()), {&a, &b});
}

Expression less(const Expression& a, const Expression& b) {
  return Expression::make_node(Operation::less, a.value() < b.value() ? 1 : 0, {&a, &b});
}

Expression less_equal(const Expression& a, const Expression& b) {
  return Expression::make_node(Operation::less_equal, a.value() <= b.value() ? 1 : 0, {&a, &b});
}

Expression equal(const Expression& a, const Expression& b) {
  return Expression::make_node(Operation::equal, a.value() == b.value() ? 1 : 0, {&a, &b});
}

Expression logical_and(const Expression& a, const Expression& b) {
  return Expression::make_node(Operation::logical_and, a.value() != 0 && b.value() != 0 ? 1 : 0, {&a, &b});
}

Expression logical_or(const Expression& a, const Expression& b) {
  return Expression::make_node(Operation::logical_or, a.value() != 0 || b.value() != 0 ? 1 : 0, {&a, &b});
}

Expression select(const Expression& condition, const Expression& yes, const Expression& no) {
  if (condition.is_constant()) return condition.value() != 0 ? yes : no;
  return Expression::make_node(Operation::select, condition.value() != 0 ? yes.value() : no.value(),
                               {&condition, &yes, &no});
}

Expression apply(int function, const Expression& x) {
  const double value = list_unary_functions()[static_cast<std::size_t>(function)].value(x.value());
  return Expression::make_node(Operation::function, value, {&x}, function);
}

Expression sin(const Expression& x) { return apply(find_unary_function("sin"), x); }
Expression cos(const Expression& x) { return apply(find_unary_function("cos"), x); }
Expression sqrt(const Expression& x) { return apply(find_unary_function("sqrt"), x); }
Expression abs(const Expression& x) { return apply(find_unary_function("abs"), x); }

namespace {

double sign(double x) { return x < 0 ? -1 : x > 0 ? 1 : 0; }
double zero_derivative(double /*x*/) { return 0; }

constexpr std::array functions{
    UnaryFunction{"sin", [](double x) { return elementary::sin(x); }, [](double x) { return elementary::cos(x); }},
    UnaryFunction{"cos", [](double x) { return elementary::cos(x); }, [](double x) { return -elementary::sin(x); }},
    UnaryFunction{"tan", [](double x) { return elementary::tan(x); },
                  [](double x) { return 1 + elementary::tan(x) * elementary::tan(x); }},
    UnaryFunction{"asin", [](double x) { return elementary::asin(x); },
                  [](double x) { return 1 / std::sqrt(1 - x * x); }},
    UnaryFunction{"acos", [](double x) { return elementary::acos(x); },
                  [](double x) { return -1 / std::sqrt(1 - x * x); }},
    UnaryFunction{"atan", [](double x) { return elementary::atan(x); }, [](double x) { return 1 / (1 + x * x); }},
    UnaryFunction{"sinh", [](double x) { return elementary::sinh(x); }, [](double x) { return elementary::cosh(x); }},
    UnaryFunction{"cosh", [](double x) { return elementary::cosh(x); }, [](double x) { return elementary::sinh(x); }},
    UnaryFunction{"tanh", [](double x) { return elementary::tanh(x); },
                  [](double x) { return 1 - elementary::tanh(x) * elementary::tanh(x); }},
    UnaryFunction{"asinh", [](double x) { return elementary::asinh(x); },
                  [](double x) { return 1 / std::sqrt(x * x + 1); }},
    UnaryFunction{"acosh", [](double x) { return elementary::acosh(x); },
                  [](double x) { return 1 / std::sqrt(x * x - 1); }},
    UnaryFunction{"atanh", [](double x) { return elementary::atanh(x); }, [](double x) { return 1 / (1 - x * x); }},
    UnaryFunction{"sqrt", [](double x) { return std::sqrt(x); },
                  // zero at zero, as for all other scalars of this program
                  [](double x) { return x == 0 ? 0 : 0.5 / std::sqrt(x); }},
    UnaryFunction{"exp", [](double x) { return elementary::exp(x); }, [](double x) { return elementary::exp(x); }},
    UnaryFunction{"ln", [](double x) { return elementary::log(x); }, [](double x) { return 1 / x; }},
    UnaryFunction{"log10", [](double x) { return elementary::log10(x); },
                  [](double x) { return 1 / (x * std::numbers::ln10); }},
    UnaryFunction{"log2", [](double x) { return elementary::log2(x); },
                  [](double x) { return 1 / (x * std::numbers::ln2); }},
    UnaryFunction{"abs", [](double x) { return x >= 0 ? x : -x; }, sign},
    UnaryFunction{"sign", sign, zero_derivative},
    UnaryFunction{"rint", [](double x) { return std::floor(x + 0.5); }, zero_derivative},
};

}  // namespace

std::span<const UnaryFunction> list_unary_functions() { return functions; }

int find_unary_function(std::string_view name) {
  const auto found =
      std::find_if(functions.begin(), functions.end(), [&](const UnaryFunction& f) { return f.name == name; });
  return static_cast<int>(found - functions.begin());
}

Expression ScalarAlgebra<Expression>::apply(const ExpressionNode& node, const Expression& a, const Expression& b,
                                            const Expression& c) const {
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
    case Operation::minimum: return minimum(a, b);
    case Operation::maximum: return maximum(a, b);
    case Operation::less: return less(a, b);
    case Operation::less_equal: return less_equal(a, b);
    case Operation::equal: return equal(a, b);
    case Operation::logical_and: return logical_and(a, b);
    case Operation::logical_or: return logical_or(a, b);
    case Operation::select: return select(a, b, c);
    case Operation::function: return expression::apply(node.function, a);
  }
  return {};
}

}  // namespace balance::expression
