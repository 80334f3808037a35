#include "balance/conditions/power_law.hpp"

#include <cmath>

namespace balance {

namespace {

bool is_independent(const PowerLaw& x) { return x.is_valid && x.exponent == 0; }

/// Of a sum, a choice, a comparison: only equal powers are one.
PowerLaw require_equal_powers(const PowerLaw& a, const PowerLaw& b) {
  return {a.is_valid && b.is_valid && a.exponent == b.exponent, a.exponent};
}

PowerLaw add_power_laws(const PowerLaw& a, const PowerLaw& b) {
  if (a.value == 0 && is_independent(a)) return b;
  if (b.value == 0 && is_independent(b)) return a;
  return require_equal_powers(a, b);
}

/// Whether a comes to the same with a larger p. Functions of what does not depend on p do not, either.
PowerLaw valid_if_independent(const PowerLaw& a) { return {is_independent(a), 0}; }

PowerLaw apply_function(const ExpressionNode& node, const PowerLaw& a) {
  static const int root = find_unary_function("sqrt"), size = find_unary_function("abs"),
                   sign = find_unary_function("sign");
  if (node.function == root) return {a.is_valid, a.exponent / 2};
  if (node.function == size) return a;
  if (node.function == sign) return {a.is_valid, 0};
  return valid_if_independent(a);
}

PowerLaw apply_operation(const ExpressionNode& node, const PowerLaw& a, const PowerLaw& b, const PowerLaw& c) {
  switch (node.operation) {
    case Operation::constant:
    case Operation::input: break;
    case Operation::alias:
    case Operation::negate: return a;
    case Operation::add:
    case Operation::subtract: return add_power_laws(a, b);
    case Operation::multiply: return {a.is_valid && b.is_valid, a.exponent + b.exponent};
    case Operation::divide: return {a.is_valid && b.is_valid, a.exponent - b.exponent};
    case Operation::power: return {a.is_valid && is_independent(b), a.exponent * b.value};
    case Operation::minimum:
    case Operation::maximum: return require_equal_powers(a, b);
    case Operation::atan2:
    case Operation::less:
    case Operation::less_equal:
    case Operation::equal: return {require_equal_powers(a, b).is_valid, 0};
    case Operation::logical_and:
    case Operation::logical_or: return {is_independent(a) && is_independent(b), 0};
    case Operation::select: {
      const PowerLaw& chosen = a.value != 0 ? b : c;
      return {is_independent(a) && chosen.is_valid, chosen.exponent};
    }
    case Operation::function: return apply_function(node, a);
  }
  return {};
}

}  // namespace

PowerLaw PowerLawAlgebra::apply(const ExpressionNode& node, const PowerLaw& a, const PowerLaw& b,
                                const PowerLaw& c) const {
  PowerLaw result = &node == base_ ? PowerLaw{true, 1} : apply_operation(node, a, b, c);
  result.value = ScalarAlgebra<double>().apply(node, a.value, b.value, c.value);
  return result;
}

}  // namespace balance
