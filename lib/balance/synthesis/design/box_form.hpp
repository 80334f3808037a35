#pragma once
/// Functions of the free numbers of a design over a box of them: values and derivatives, enclosed by intervals.

#include "balance/foundation/base/interval.hpp"
#include "balance/foundation/expression/expression_evaluation.hpp"

#include <array>
#include <cmath>
#include <string_view>

namespace balance::design {

/// Free numbers of a program that chooses rows of catalogues.
inline constexpr int max_places = 8;

/// Encloses a function and its derivatives by the places.
struct BoxForm {
  Interval value;
  std::array<Interval, max_places> gradient;  ///< of which the first `places` count
};

/// Arithmetic of such functions.
class BoxAlgebra {
 public:
  using Value = BoxForm;

  explicit BoxAlgebra(int places) : n_(places) {}

  BoxForm constant(const Interval& value) const { return {value, {}}; }
  BoxForm place(int i, const Interval& range) const {
    BoxForm form{range, {}};
    form.gradient[static_cast<std::size_t>(i)] = 1.0;
    return form;
  }
  BoxForm add(const BoxForm& a, const BoxForm& b) const { return combine(a.value + b.value, a, 1.0, b, 1.0); }
  BoxForm subtract(const BoxForm& a, const BoxForm& b) const { return combine(a.value - b.value, a, 1.0, b, -1.0); }
  BoxForm multiply(const BoxForm& a, const BoxForm& b) const {
    return combine(a.value * b.value, a, b.value, b, a.value);
  }
  BoxForm scale(const BoxForm& a, const Interval& factor) const {
    BoxForm out{a.value * factor, {}};
    for (std::size_t i = 0; i < size(); ++i) out.gradient[i] = a.gradient[i] * factor;
    return out;
  }
  BoxForm square(const BoxForm& a) const { return chain(a, balance::square(a.value), a.value * 2.0); }
  BoxForm inverse(const BoxForm& a) const {
    const Interval r = balance::inverse(a.value);
    return chain(a, r, -balance::square(r));
  }
  BoxForm sqrt(const BoxForm& a) const {
    const Interval root = balance::sqrt(a.value);
    return chain(a, root, balance::inverse(root) * 0.5);
  }

  /// @throws EnclosureError for an operation that cannot be enclosed
  BoxForm apply(const expression::ExpressionNode& node, const BoxForm& a, const BoxForm& b, const BoxForm& c) const {
    using expression::Operation;
    switch (node.operation) {
      case Operation::alias: return a;
      case Operation::add: return add(a, b);
      case Operation::subtract: return subtract(a, b);
      case Operation::multiply: return multiply(a, b);
      case Operation::divide: return multiply(a, inverse(b));
      case Operation::negate: return scale(a, -1.0);
      case Operation::power: return power(a, b);
      case Operation::minimum: return is_less(a, b) ? a : b;
      case Operation::maximum: return is_less(a, b) ? b : a;
      case Operation::less: return constant(is_less(a, b) ? 1.0 : 0.0);
      case Operation::less_equal: return constant(is_less(b, a) ? 0.0 : 1.0);
      case Operation::equal: return constant(is_equal(a, b) ? 1.0 : 0.0);
      case Operation::select:
        if (!a.value.is_point()) break;
        return a.value.lower != 0 ? b : c;
      case Operation::function: return apply_function(node, a);
      default: break;
    }
    throw EnclosureError("an expression cannot be enclosed");
  }

 private:
  std::size_t size() const { return static_cast<std::size_t>(n_); }
  BoxForm combine(const Interval& value, const BoxForm& a, const Interval& p, const BoxForm& b,
                  const Interval& q) const {
    BoxForm out{value, {}};
    for (std::size_t i = 0; i < size(); ++i) out.gradient[i] = a.gradient[i] * p + b.gradient[i] * q;
    return out;
  }
  BoxForm chain(const BoxForm& x, const Interval& value, const Interval& derivative) const {
    BoxForm out{value, {}};
    for (std::size_t i = 0; i < size(); ++i) out.gradient[i] = x.gradient[i] * derivative;
    return out;
  }
  BoxForm power(const BoxForm& a, const BoxForm& b) const {
    const double exponent = b.value.middle();
    if (!b.value.is_point()) throw EnclosureError("a power with a variable exponent");
    if (exponent == 0.5) return sqrt(a);
    if (exponent != std::floor(exponent) || std::abs(exponent) > 8)
      throw EnclosureError("a power that is not a whole number");
    BoxForm out = constant(1.0);
    for (int k = 0; k < static_cast<int>(std::abs(exponent)); ++k) out = multiply(out, a);
    return exponent < 0 ? inverse(out) : out;
  }
  /// @throws EnclosureError if it depends on the place in the box
  static bool is_less(const BoxForm& a, const BoxForm& b) {
    if (a.value.upper < b.value.lower) return true;
    if (b.value.upper <= a.value.lower) return false;
    throw EnclosureError("a comparison that differs over the box");
  }
  static bool is_equal(const BoxForm& a, const BoxForm& b) {
    if (a.value.upper < b.value.lower || b.value.upper < a.value.lower) return false;
    if (a.value.is_point() && b.value.is_point()) return true;
    throw EnclosureError("a comparison that differs over the box");
  }
  BoxForm apply_function(const expression::ExpressionNode& node, const BoxForm& x) const {
    const std::string_view name = expression::list_unary_functions()[static_cast<std::size_t>(node.function)].name;
    if (name == "sin") return chain(x, sin(x.value), cos(x.value));
    if (name == "cos") return chain(x, cos(x.value), -sin(x.value));
    if (name == "sqrt") return sqrt(x);
    if (name == "abs" && x.value.lower >= 0) return x;
    if (name == "abs" && x.value.upper <= 0) return scale(x, -1.0);
    throw EnclosureError("a function that cannot be enclosed");
  }

  int n_;
};

}  // namespace balance::design
