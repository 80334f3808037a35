#pragma once
/// Numbers that carry their derivatives: forward differentiation, exact to round-off. Comparisons and branches look at the value
/// alone.

#include "balance/foundation/base/elementary.hpp"
#include "balance/foundation/base/types.hpp"

#include <cmath>
#include <cstddef>
#include <utility>

namespace balance {

// Rows of numbers that are added and multiplied together: the derivatives of a Dual.

namespace duals {

/// What every x86-64 processor works on at once, aligned like one number. The same for every source: programs that use the library may be
/// compiled for other processors than it is.
using Pair __attribute__((vector_size(16), aligned(8), may_alias)) = double;

template <int N, bool Even = N % 2 == 0>
struct DerivativeStorage {
  static constexpr int count = N / 2;
  Pair parts[count] = {};
};
template <int N>
struct DerivativeStorage<N, false> {
  static constexpr int count = N;
  double parts[count] = {};
};

}  // namespace duals

/// N numbers, in memory one after another on every processor.
template <int N>
class Derivatives {
 public:
  static constexpr std::size_t size() { return N; }
  double& operator[](std::size_t i) { return begin()[i]; }
  double operator[](std::size_t i) const { return begin()[i]; }
  double* begin() { return reinterpret_cast<double*>(row_.parts); }
  double* end() { return begin() + N; }
  const double* begin() const { return reinterpret_cast<const double*>(row_.parts); }
  const double* end() const { return begin() + N; }

  Derivatives& operator+=(const Derivatives& b) { return *this = *this + b; }
  Derivatives& operator-=(const Derivatives& b) { return *this = *this - b; }
  friend Derivatives operator+(const Derivatives& a, const Derivatives& b) {
    return each([&](int i) { return a.row_.parts[i] + b.row_.parts[i]; });
  }
  friend Derivatives operator-(const Derivatives& a, const Derivatives& b) {
    return each([&](int i) { return a.row_.parts[i] - b.row_.parts[i]; });
  }
  friend Derivatives operator*(const Derivatives& a, double b) {
    return each([&](int i) { return a.row_.parts[i] * b; });
  }
  friend Derivatives operator*(double a, const Derivatives& b) { return b * a; }
  friend Derivatives operator/(const Derivatives& a, double b) {
    return each([&](int i) { return a.row_.parts[i] / b; });
  }

 private:
  template <class Part>
  static Derivatives each(const Part& part) {
    return all(part, std::make_integer_sequence<int, duals::DerivativeStorage<N>::count>());
  }
  // Not a loop: compilers keep what is counted by one in memory, and this in registers.
  template <class Part, int... I>
  static Derivatives all(const Part& part, std::integer_sequence<int, I...>) {
    Derivatives out;
    ((out.row_.parts[I] = part(I)), ...);
    return out;
  }

  duals::DerivativeStorage<N> row_;
};

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
