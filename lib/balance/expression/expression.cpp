#include "balance/expression/expression.hpp"

#include "balance/base/elementary.hpp"

#include <algorithm>
#include <cmath>

namespace balance {

Expression Expression::made(Operation operation, double value, std::initializer_list<const Expression*> arguments,
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

bool is(const Expression& x, double value) { return x.is_constant() && x.value() == value; }
/// Neutral elements fall away beside what may change; among constants even a zero's sign is that of the sum.
bool both_constant(const Expression& a, const Expression& b) { return a.is_constant() && b.is_constant(); }

}  // namespace

Expression Expression::named(ExpressionGraph& graph, const Expression& x) {
  const int argument = x.is_constant() ? graph.add({.constant = x.value_}) : x.node_;
  return {x.value_, graph.add({.operation = Operation::name, .arguments = {argument, -1, -1}}), &graph};
}

Expression operator+(const Expression& a, const Expression& b) {
  if (both_constant(a, b)) return a.value_ + b.value_;
  if (is(a, 0)) return b;
  if (is(b, 0)) return a;
  return Expression::made(Operation::add, a.value_ + b.value_, {&a, &b});
}

Expression operator-(const Expression& a, const Expression& b) {
  if (both_constant(a, b)) return a.value_ - b.value_;
  if (is(a, 0)) return -b;
  if (is(b, 0)) return a;
  return Expression::made(Operation::subtract, a.value_ - b.value_, {&a, &b});
}

Expression operator*(const Expression& a, const Expression& b) {
  if (is(a, 1)) return b;
  if (is(b, 1)) return a;
  if (is(a, 0) || is(b, 0)) return a.value_ * b.value_;
  return Expression::made(Operation::multiply, a.value_ * b.value_, {&a, &b});
}

Expression operator/(const Expression& a, const Expression& b) {
  if (is(b, 1)) return a;
  return Expression::made(Operation::divide, a.value_ / b.value_, {&a, &b});
}

Expression operator-(const Expression& a) { return Expression::made(Operation::negate, -a.value_, {&a}); }

Expression power(const Expression& base, const Expression& exponent) {
  if (is(exponent, 1)) return base;
  return Expression::made(Operation::power, elementary::pow(base.value(), exponent.value()), {&base, &exponent});
}

Expression atan2(const Expression& y, const Expression& x) {
  return Expression::made(Operation::atan2, elementary::atan2(y.value(), x.value()), {&y, &x});
}

Expression minimum(const Expression& a, const Expression& b) {
  return Expression::made(Operation::minimum, std::min(a.value(), b.value()), {&a, &b});
}

Expression maximum(const Expression& a, const Expression& b) {
  return Expression::made(Operation::maximum, std::max(a.value(), b.value()), {&a, &b});
}

Expression less(const Expression& a, const Expression& b) {
  return Expression::made(Operation::less, a.value() < b.value() ? 1 : 0, {&a, &b});
}

Expression at_most(const Expression& a, const Expression& b) {
  return Expression::made(Operation::at_most, a.value() <= b.value() ? 1 : 0, {&a, &b});
}

Expression equal(const Expression& a, const Expression& b) {
  return Expression::made(Operation::equal, a.value() == b.value() ? 1 : 0, {&a, &b});
}

Expression both(const Expression& a, const Expression& b) {
  return Expression::made(Operation::both, a.value() != 0 && b.value() != 0 ? 1 : 0, {&a, &b});
}

Expression either(const Expression& a, const Expression& b) {
  return Expression::made(Operation::either, a.value() != 0 || b.value() != 0 ? 1 : 0, {&a, &b});
}

Expression choose(const Expression& condition, const Expression& yes, const Expression& no) {
  if (condition.is_constant()) return condition.value() != 0 ? yes : no;
  return Expression::made(Operation::choose, condition.value() != 0 ? yes.value() : no.value(),
                          {&condition, &yes, &no});
}

Expression apply(int function, const Expression& x) {
  const double value = unary_functions()[static_cast<std::size_t>(function)].value(x.value());
  return Expression::made(Operation::function, value, {&x}, function);
}

Expression sin(const Expression& x) { return apply(unary_function("sin"), x); }
Expression cos(const Expression& x) { return apply(unary_function("cos"), x); }
Expression sqrt(const Expression& x) { return apply(unary_function("sqrt"), x); }
Expression abs(const Expression& x) { return apply(unary_function("abs"), x); }

}  // namespace balance
