#pragma once
/// Numbers that carry their derivatives: forward differentiation, exact to round-off. Comparisons and branches look at the value
/// alone.

#include "balance/base/derivatives.hpp"
#include "balance/base/elementary.hpp"
#include "balance/base/types.hpp"

#include <cmath>
#include <cstddef>

namespace balance {

/// A value and its derivatives with respect to N numbers.
template <int N>
struct Dual {
  double value = 0;
  Derivatives<N> d;  ///< per number

  Dual() = default;
  Dual(double constant) : value(constant) {}  // NOLINT(google-explicit-constructor): a constant is a number, too
  /// The k-th of the numbers that derivatives are taken with respect to.
  static Dual variable(double value, int k) {
    Dual x(value);
    x.d[static_cast<std::size_t>(k)] = 1;
    return x;
  }

  Dual& operator+=(const Dual& b) {
    value += b.value;
    d += b.d;
    return *this;
  }
  Dual& operator-=(const Dual& b) {
    value -= b.value;
    d -= b.d;
    return *this;
  }
  Dual& operator*=(const Dual& b) {
    d = d * b.value + value * b.d;
    value *= b.value;
    return *this;
  }
  Dual& operator*=(double b) {
    d = d * b;
    value *= b;
    return *this;
  }
  Dual& operator/=(const Dual& b) {
    const double inverse = 1 / b.value;
    value /= b.value;
    d = (d - value * b.d) * inverse;
    return *this;
  }
  // From both to a new one: a copy that is added to would be carried through memory twice.
  friend Dual operator+(const Dual& a, const Dual& b) {
    Dual out(a.value + b.value);
    out.d = a.d + b.d;
    return out;
  }
  friend Dual operator-(const Dual& a, const Dual& b) {
    Dual out(a.value - b.value);
    out.d = a.d - b.d;
    return out;
  }
  friend Dual operator*(const Dual& a, const Dual& b) {
    Dual out(a.value * b.value);
    out.d = a.d * b.value + a.value * b.d;
    return out;
  }
  friend Dual operator*(const Dual& a, double b) {
    Dual out(a.value * b);
    out.d = a.d * b;
    return out;
  }
  friend Dual operator*(double a, const Dual& b) { return b * a; }
  friend Dual operator/(Dual a, const Dual& b) { return a /= b; }
  friend Dual operator+(const Dual& a) { return a; }
  friend Dual operator-(Dual a) { return a *= -1.0; }

  friend bool operator==(const Dual& a, const Dual& b) { return a.value == b.value; }
  friend auto operator<=>(const Dual& a, const Dual& b) { return a.value <=> b.value; }
};

inline double value_of(double x) { return x; }
template <int N>
double value_of(const Dual<N>& x) {
  return x.value;
}

/// f(x) where f has this value and this derivative at x.
template <int N>
Dual<N> apply_chain_rule(const Dual<N>& x, double value, double derivative) {
  Dual<N> out(value);
  out.d = derivative * x.d;
  return out;
}

template <int N>
Dual<N> sin(const Dual<N>& x) {
  return apply_chain_rule(x, elementary::sin(x.value), elementary::cos(x.value));
}
template <int N>
Dual<N> cos(const Dual<N>& x) {
  return apply_chain_rule(x, elementary::cos(x.value), -elementary::sin(x.value));
}
template <int N>
Dual<N> tan(const Dual<N>& x) {
  const double t = elementary::tan(x.value);
  return apply_chain_rule(x, t, 1 + t * t);
}
template <int N>
Dual<N> asin(const Dual<N>& x) {
  return apply_chain_rule(x, elementary::asin(x.value), 1 / std::sqrt(1 - x.value * x.value));
}
template <int N>
Dual<N> acos(const Dual<N>& x) {
  return apply_chain_rule(x, elementary::acos(x.value), -1 / std::sqrt(1 - x.value * x.value));
}
template <int N>
Dual<N> atan(const Dual<N>& x) {
  return apply_chain_rule(x, elementary::atan(x.value), 1 / (1 + x.value * x.value));
}
template <int N>
Dual<N> exp(const Dual<N>& x) {
  const double e = elementary::exp(x.value);
  return apply_chain_rule(x, e, e);
}
template <int N>
Dual<N> log(const Dual<N>& x) {
  return apply_chain_rule(x, elementary::log(x.value), 1 / x.value);
}
/// At zero, where the root has no derivative, those of zero: a length that vanishes with its whole neighbourhood has none to show.
template <int N>
Dual<N> sqrt(const Dual<N>& x) {
  const double root = std::sqrt(x.value);
  return apply_chain_rule(x, root, root > 0 ? 0.5 / root : 0);
}
template <int N>
Dual<N> abs(const Dual<N>& x) {
  return x.value < 0 ? -x : x;
}
template <int N>
Dual<N> atan2(const Dual<N>& y, const Dual<N>& x) {
  const double square = x.value * x.value + y.value * y.value;
  Dual<N> out(elementary::atan2(y.value, x.value));
  out.d = (x.value * y.d - y.value * x.d) / square;
  return out;
}
template <int N>
Dual<N> hypot(const Dual<N>& x, const Dual<N>& y) {
  return sqrt(x * x + y * y);
}
/// x to a constant power.
template <int N>
Dual<N> pow(const Dual<N>& x, double power) {
  return apply_chain_rule(x, elementary::pow(x.value, power),
                          power == 0 ? 0 : power * elementary::pow(x.value, power - 1));
}
template <int N>
bool isfinite(const Dual<N>& x) {
  for (const double d : x.d)
    if (!std::isfinite(d)) return false;
  return std::isfinite(x.value);
}

template <int N>
void sine_cosine_into(const Dual<N>& x, Dual<N>& s, Dual<N>& c) {
  double sine, cosine;
  sine_cosine_into(x.value, sine, cosine);
  s = apply_chain_rule(x, sine, cosine);
  c = apply_chain_rule(x, cosine, -sine);
}

}  // namespace balance

/// So that vectors and matrices may have such entries.
template <int N>
struct Eigen::NumTraits<balance::Dual<N>> : Eigen::NumTraits<double> {
  using Real = balance::Dual<N>;
  using NonInteger = balance::Dual<N>;
  using Nested = balance::Dual<N>;
  using Literal = double;
  enum { RequireInitialization = 1, ReadCost = N + 1, AddCost = N + 1, MulCost = 2 * N + 1 };
};
template <int N, class Operation>
struct Eigen::ScalarBinaryOpTraits<balance::Dual<N>, double, Operation> {
  using ReturnType = balance::Dual<N>;
};
template <int N, class Operation>
struct Eigen::ScalarBinaryOpTraits<double, balance::Dual<N>, Operation> {
  using ReturnType = balance::Dual<N>;
};
