#include "balance/synthesis/certificate/mechanism_enclosure.hpp"

#include "balance/mechanics/model/mechanism_conversion.hpp"

#include <cmath>

namespace balance::certificate {

using expression::ExpressionNode;
using expression::Operation;

namespace {

/// Of functions of constants, relative and absolute: more than the error of any of them.
constexpr double function_margin = 0x1p-48;
constexpr int max_integer_power = 64;

IntervalJet widened_constant(double value) {
  const double margin = function_margin * (1 + std::abs(value));
  return Interval::widened(value - margin, value + margin);
}

bool is_number(const IntervalJet& x) { return x.is_constant() && x.value.is_point(); }

/// Arithmetic on jets. Branches must be the same on the whole box.
struct IntervalAlgebra {
  using Value = IntervalJet;

  IntervalJet constant(double value) const { return value; }

  IntervalJet apply(const ExpressionNode& node, const IntervalJet& a, const IntervalJet& b,
                    const IntervalJet& c) const {
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
      case Operation::atan2:
        if (is_number(a) && is_number(b)) return widened_constant(elementary::atan2(a.value.lower, b.value.lower));
        break;
      case Operation::minimum: return is_less(b, a) ? b : a;
      case Operation::maximum: return is_less(a, b) ? b : a;
      case Operation::less: return is_less(a, b) ? 1.0 : 0.0;
      case Operation::less_equal: return is_less(b, a) ? 0.0 : 1.0;
      case Operation::equal: return is_number(a) && is_number(b) ? a.value.lower == b.value.lower : differ(a, b);
      case Operation::logical_and: return is_true(a) && is_true(b) ? 1.0 : 0.0;
      case Operation::logical_or: return is_true(a) || is_true(b) ? 1.0 : 0.0;
      case Operation::select: return is_true(a) ? b : c;
      case Operation::function: return apply_function(node.function, a);
    }
    throw EnclosureError("an expression of the lengths has no enclosure");
  }

 private:
  static bool is_less(const IntervalJet& a, const IntervalJet& b) {
    if (a.value.upper < b.value.lower) return true;
    if (a.value.lower >= b.value.upper) return false;
    throw EnclosureError("a branch depends on the lengths");
  }
  static double differ(const IntervalJet& a, const IntervalJet& b) {
    if (a.value.upper < b.value.lower || b.value.upper < a.value.lower) return 0;
    throw EnclosureError("a branch depends on the lengths");
  }
  static bool is_true(const IntervalJet& x) {
    if (!x.value.contains(0)) return true;
    if (x.value.is_point()) return false;
    throw EnclosureError("a branch depends on the lengths");
  }
  static IntervalJet power(const IntervalJet& a, const IntervalJet& b) {
    if (is_number(a) && is_number(b)) return widened_constant(elementary::pow(a.value.lower, b.value.lower));
    const double exponent = b.value.lower;
    if (is_number(b) && exponent == 0.5) return sqrt(a);
    if (!is_number(b) || exponent != std::floor(exponent) || std::abs(exponent) > max_integer_power)
      throw EnclosureError("a power of the lengths has no enclosure");
    IntervalJet product = 1.0;
    for (int k = 0; k < static_cast<int>(std::abs(exponent)); ++k) product *= a;
    return exponent < 0 ? inverse(product) : product;
  }
  static IntervalJet apply_function(int index, const IntervalJet& x) {
    const expression::UnaryFunction& function = expression::list_unary_functions()[static_cast<std::size_t>(index)];
    if (is_number(x)) return widened_constant(function.value(x.value.lower));
    if (function.name == "sqrt") return sqrt(x);
    if (function.name == "sin") return sin(x);
    if (function.name == "cos") return cos(x);
    if (function.name == "abs") return is_less(x, 0.0) ? -x : x;
    throw EnclosureError("a function of the lengths has no enclosure");
  }
};

}  // namespace

NumberDependence::NumberDependence(const DesignSpace& space) : recording_(*space.recording) {
  number_of_input_.assign(space.inputs.size(), -1);
  for (std::size_t i = 0; i < space.free_inputs.size(); ++i)
    number_of_input_[static_cast<std::size_t>(space.free_inputs[i])] = static_cast<int>(i);
  for (const ExpressionNode& node : recording_.graph.nodes()) {
    std::set<int> own;
    if (node.operation == Operation::input && number_of_input_[static_cast<std::size_t>(node.input)] >= 0)
      own.insert(number_of_input_[static_cast<std::size_t>(node.input)]);
    for (const int argument : node.arguments)
      if (argument >= 0) own.merge(std::set<int>(numbers_[static_cast<std::size_t>(argument)]));
    numbers_.push_back(std::move(own));
  }
}

const std::set<int>& NumberDependence::of(const Expression& expression) const {
  return expression.is_constant() ? none_ : numbers_[static_cast<std::size_t>(expression.node())];
}

int NumberDependence::number_of(const Expression& expression) const {
  if (expression.is_constant()) return -1;
  const std::vector<ExpressionNode>& nodes = recording_.graph.nodes();
  auto node = static_cast<std::size_t>(expression.node());
  while (nodes[node].operation == Operation::alias) node = static_cast<std::size_t>(nodes[node].arguments[0]);
  return nodes[node].operation == Operation::input ? number_of_input_[static_cast<std::size_t>(nodes[node].input)] : -1;
}

MechanismOf<IntervalJet> enclose_mechanism(const DesignSpace& space, const std::vector<IntervalJet>& numbers) {
  std::vector<IntervalJet> inputs(space.inputs.begin(), space.inputs.end());
  for (std::size_t i = 0; i < numbers.size(); ++i) inputs[static_cast<std::size_t>(space.free_inputs[i])] = numbers[i];
  const std::vector<IntervalJet> values = evaluate(space.recording->graph, inputs, IntervalAlgebra());
  return model::convert_mechanism<IntervalJet>(space.recording->mechanism, [&](const Expression& x) {
    return x.is_constant() ? IntervalJet(x.value()) : values[static_cast<std::size_t>(x.node())];
  });
}

}  // namespace balance::certificate
