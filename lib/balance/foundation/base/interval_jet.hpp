#pragma once
/// Functions of a few numbers that lie in a box: intervals that contain their values, first and second derivatives at
/// every point of the box (second-order forward differentiation in interval arithmetic).

#include "balance/foundation/base/interval.hpp"
#include "balance/foundation/base/types.hpp"

#include <array>

namespace balance {

/// Constants have no variables, and cost as little as intervals. Derivatives up to `order` are known; those of a function
/// of several jets have the same variables and order.
class IntervalJet {
 public:
  static constexpr int max_variables = 4;

  IntervalJet() {}                                   // NOLINT(modernize-use-equals-default): derivatives are left open
  IntervalJet(double constant) : value(constant) {}  // NOLINT(google-explicit-constructor)
  IntervalJet(const Interval& constant) : value(constant) {}  // NOLINT(google-explicit-constructor)
  /// Number k of `variables`, in x.
  static IntervalJet variable(const Interval& x, int k, int variables, int order) {
    IntervalJet jet(x);
    jet.set_variables(variables, order);
    if (order > 0) jet.gradient(k) = 1.0;
    return jet;
  }

  // Only what is known is copied: most jets are small.
  IntervalJet(const IntervalJet& b) : value(b.value), variables_(b.variables_), order_(b.order_) {
    copy_derivatives(b);
  }
  IntervalJet& operator=(const IntervalJet& b) {
    value = b.value;
    variables_ = b.variables_;
    order_ = b.order_;
    copy_derivatives(b);
    return *this;
  }
  ~IntervalJet() = default;

  Interval value;

  int variables() const { return variables_; }
  int order() const { return order_; }
  bool is_constant() const { return variables_ == 0 || order_ == 0; }
  /// Makes room for derivatives, which become zero.
  void set_variables(int variables, int order) {
    variables_ = variables;
    order_ = order;
    for (int i = 0; i < gradient_size(); ++i) gradient_[at(i)] = Interval();
    for (int k = 0; k < hessian_size(); ++k) hessian_[at(k)] = Interval();
  }

  Interval& gradient(int i) { return gradient_[at(i)]; }
  const Interval& gradient(int i) const { return gradient_[at(i)]; }
  /// @param i, j in any order
  Interval& hessian(int i, int j) { return hessian_[at(index(i, j))]; }
  const Interval& hessian(int i, int j) const { return hessian_[at(index(i, j))]; }
  /// Of a function that may be a constant.
  Interval derivative(int i) const { return order_ >= 1 && i < variables_ ? gradient_[at(i)] : Interval(); }
  Interval second_derivative(int i, int j) const {
    return order_ >= 2 && std::max(i, j) < variables_ ? hessian(i, j) : Interval();
  }

  friend IntervalJet operator+(const IntervalJet& a, const IntervalJet& b) {
    if (a.is_constant()) return shift(b, a.value);
    if (b.is_constant()) return shift(a, b.value);
    IntervalJet out(a.value + b.value, a);
    for (int i = 0; i < out.gradient_size(); ++i) out.gradient_[at(i)] = a.gradient_[at(i)] + b.gradient_[at(i)];
    for (int k = 0; k < out.hessian_size(); ++k) out.hessian_[at(k)] = a.hessian_[at(k)] + b.hessian_[at(k)];
    return out;
  }
  friend IntervalJet operator-(const IntervalJet& a) {
    IntervalJet out(-a.value, a);
    for (int i = 0; i < out.gradient_size(); ++i) out.gradient_[at(i)] = -a.gradient_[at(i)];
    for (int k = 0; k < out.hessian_size(); ++k) out.hessian_[at(k)] = -a.hessian_[at(k)];
    return out;
  }
  friend IntervalJet operator-(const IntervalJet& a, const IntervalJet& b) { return a + (-b); }
  friend IntervalJet operator*(const IntervalJet& a, const IntervalJet& b) {
    if (a.is_constant()) return scale(b, a.value);
    if (b.is_constant()) return scale(a, b.value);
    IntervalJet out(a.value * b.value, a);
    const int n = a.variables_;
    for (int i = 0; i < out.gradient_size(); ++i)
      out.gradient_[at(i)] = a.gradient_[at(i)] * b.value + a.value * b.gradient_[at(i)];
    if (out.order_ < 2) return out;
    for (int j = 0, k = 0; j < n; ++j)
      for (int i = 0; i <= j; ++i, ++k) {
        const Interval first = a.gradient_[at(i)] * b.gradient_[at(j)];
        const Interval cross = i == j ? first * 2 : first + a.gradient_[at(j)] * b.gradient_[at(i)];
        out.hessian_[at(k)] = a.hessian_[at(k)] * b.value + a.value * b.hessian_[at(k)] + cross;
      }
    return out;
  }
  friend IntervalJet operator*(const IntervalJet& a, double b) { return scale(a, b); }
  friend IntervalJet operator*(double a, const IntervalJet& b) { return scale(b, a); }
  friend IntervalJet operator/(const IntervalJet& a, const IntervalJet& b) { return a * inverse(b); }
  IntervalJet& operator+=(const IntervalJet& b) { return *this = *this + b; }
  IntervalJet& operator-=(const IntervalJet& b) { return *this = *this - b; }
  IntervalJet& operator*=(const IntervalJet& b) { return *this = *this * b; }
  IntervalJet& operator/=(const IntervalJet& b) { return *this = *this / b; }

  // Certainly so on the whole box: false in doubt.
  friend bool operator<(const IntervalJet& a, const IntervalJet& b) { return a.value.upper < b.value.lower; }
  friend bool operator>(const IntervalJet& a, const IntervalJet& b) { return b < a; }

  /// f(x), given intervals of f, f′ and f″ on the values of x.
  friend IntervalJet apply_chain_rule(const IntervalJet& x, const Interval& value, const Interval& first,
                                      const Interval& second) {
    if (x.is_constant()) return value;
    IntervalJet out(value, x);
    for (int i = 0; i < out.gradient_size(); ++i) out.gradient_[at(i)] = first * x.gradient_[at(i)];
    if (out.order_ < 2) return out;
    for (int j = 0, k = 0; j < x.variables_; ++j)
      for (int i = 0; i <= j; ++i, ++k) {
        const Interval product = i == j ? square(x.gradient_[at(i)]) : x.gradient_[at(i)] * x.gradient_[at(j)];
        out.hessian_[at(k)] = first * x.hessian_[at(k)] + second * product;
      }
    return out;
  }
  friend IntervalJet inverse(const IntervalJet& x) {
    const Interval r = inverse(x.value), r2 = square(r);
    return apply_chain_rule(x, r, -r2, r2 * r * 2);
  }
  friend IntervalJet sqrt(const IntervalJet& x) {
    const Interval root = sqrt(x.value);
    if (x.is_constant()) return root;
    const Interval r = inverse(root);
    return apply_chain_rule(x, root, r * 0.5, r * square(r) * -0.25);
  }
  friend IntervalJet sin(const IntervalJet& x) {
    const Interval s = sin(x.value);
    return x.is_constant() ? IntervalJet(s) : apply_chain_rule(x, s, cos(x.value), -s);
  }
  friend IntervalJet cos(const IntervalJet& x) {
    const Interval c = cos(x.value);
    return x.is_constant() ? IntervalJet(c) : apply_chain_rule(x, c, -sin(x.value), -c);
  }
  /// The overload that the recursions call.
  friend void sine_cosine_into(const IntervalJet& x, IntervalJet& s, IntervalJet& c) {
    const Interval sine = sin(x.value), cosine = cos(x.value);
    s = apply_chain_rule(x, sine, cosine, -sine);
    c = apply_chain_rule(x, cosine, -sine, -cosine);
  }
  friend double value_of(const IntervalJet& x) { return x.value.middle(); }

 private:
  /// Derivatives are left open.
  IntervalJet(const Interval& v, const IntervalJet& like)
      : value(v), variables_(like.variables_), order_(like.order_) {}

  static std::size_t at(int i) { return static_cast<std::size_t>(i); }
  static int index(int i, int j) { return i > j ? i * (i + 1) / 2 + j : j * (j + 1) / 2 + i; }
  int gradient_size() const { return order_ >= 1 ? variables_ : 0; }
  int hessian_size() const { return order_ >= 2 ? variables_ * (variables_ + 1) / 2 : 0; }
  // GCC cannot tell that derivatives beyond the sizes, which are left open, are not read.
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#endif
  void copy_derivatives(const IntervalJet& b) {
    for (int i = 0; i < gradient_size(); ++i) gradient_[at(i)] = b.gradient_[at(i)];
    for (int k = 0; k < hessian_size(); ++k) hessian_[at(k)] = b.hessian_[at(k)];
  }
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic pop
#endif
  static IntervalJet shift(const IntervalJet& a, const Interval& b) {
    IntervalJet out = a;
    out.value = a.value + b;
    return out;
  }
  static IntervalJet scale(const IntervalJet& a, const Interval& b) {
    IntervalJet out(a.value * b, a);
    for (int i = 0; i < out.gradient_size(); ++i) out.gradient_[at(i)] = a.gradient_[at(i)] * b;
    for (int k = 0; k < out.hessian_size(); ++k) out.hessian_[at(k)] = a.hessian_[at(k)] * b;
    return out;
  }

  int variables_ = 0, order_ = 0;
  // Unions are not initialised: most jets have few derivatives, and need not set the others.
  // NOLINTBEGIN(readability-identifier-naming): private, in spite of the union
  union {
    std::array<Interval, max_variables> gradient_;
  };
  union {
    std::array<Interval, max_variables*(max_variables + 1) / 2> hessian_;  ///< columns of the upper triangle
  };
  // NOLINTEND(readability-identifier-naming)
};

}  // namespace balance

/// Lets Eigen vectors and matrices hold jets.
template <>
struct Eigen::NumTraits<balance::IntervalJet> : Eigen::NumTraits<double> {
  using Real = balance::IntervalJet;
  using NonInteger = balance::IntervalJet;
  using Nested = balance::IntervalJet;
  using Literal = double;
  enum { RequireInitialization = 1, ReadCost = 10, AddCost = 20, MulCost = 100 };
};
template <class Operation>
struct Eigen::ScalarBinaryOpTraits<balance::IntervalJet, double, Operation> {
  using ReturnType = balance::IntervalJet;
};
template <class Operation>
struct Eigen::ScalarBinaryOpTraits<double, balance::IntervalJet, Operation> {
  using ReturnType = balance::IntervalJet;
};
