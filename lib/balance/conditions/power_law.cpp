#include "balance/conditions/power_law.hpp"

#include <cmath>

namespace balance {

namespace {

bool is_independent(const PowerLaw& x) { return x.holds && x.exponent == 0; }

/// Of a sum, a choice, a comparison: only equal powers are one.
PowerLaw same_power(const PowerLaw& a, const PowerLaw& b) {
  return {a.holds && b.holds && a.exponent == b.exponent, a.exponent};
}

PowerLaw sum(const PowerLaw& a, const PowerLaw& b) {
  if (a.value == 0 && is_independent(a)) return b;
  if (b.value == 0 && is_independent(b)) return a;
  return same_power(a, b);
}

/// Whether a comes to the same with a larger p. Functions of what does not depend on p do not, either.
PowerLaw if_independent(const PowerLaw& a) { return {is_independent(a), 0}; }

PowerLaw function(const ExpressionNode& node, const PowerLaw& a) {
  static const int root = unary_function("sqrt"), size = unary_function("abs"), sign = unary_function("sign");
  if (node.function == root) return {a.holds, a.exponent / 2};
  if (node.function == size) return a;
  if (node.function == sign) return {a.holds, 0};
  return if_independent(a);
}

PowerLaw law(const ExpressionNode& node, const PowerLaw& a, const PowerLaw& b, const PowerLaw& c) {
  switch (node.operation) {
    case Operation::constant:
    case Operation::input: break;
    case Operation::name:
    case Operation::negate: return a;
    case Operation::add:
    case Operation::subtract: return sum(a, b);
    case Operation::multiply: return {a.holds && b.holds, a.exponent + b.exponent};
    case Operation::divide: return {a.holds && b.holds, a.exponent - b.exponent};
    case Operation::power: return {a.holds && is_independent(b), a.exponent * b.value};
    case Operation::minimum:
    case Operation::maximum: return same_power(a, b);
    case Operation::atan2:
    case Operation::less:
    case Operation::at_most:
    case Operation::equal: return {same_power(a, b).holds, 0};
    case Operation::both:
    case Operation::either: return {is_independent(a) && is_independent(b), 0};
    case Operation::choose: {
      const PowerLaw& chosen = a.value != 0 ? b : c;
      return {is_independent(a) && chosen.holds, chosen.exponent};
    }
    case Operation::function: return function(node, a);
  }
  return {};
}

}  // namespace

PowerLaw PowerLawAlgebra::operate(const ExpressionNode& node, const PowerLaw& a, const PowerLaw& b,
                                  const PowerLaw& c) const {
  PowerLaw result = &node == base_ ? PowerLaw{true, 1} : law(node, a, b, c);
  result.value = ScalarAlgebra<double>().operate(node, a.value, b.value, c.value);
  return result;
}

}  // namespace balance
