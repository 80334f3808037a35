#include "balance/expression/evaluation.hpp"

namespace balance {

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
    case Operation::function: return balance::apply(node.function, a);
  }
  return {};
}

}  // namespace balance
