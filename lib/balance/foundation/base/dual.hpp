#pragma once
/// Dual numbers: forward-mode differentiation, exact to round-off. Comparisons and branches depend on the value only.

#include "balance/foundation/base/elementary.hpp"
#include "balance/foundation/base/types.hpp"

#include <cmath>
#include <cstddef>
#include <utility>

namespace balance {

// Vectors of derivatives that are added and multiplied as a whole.

namespace duals {

/// A vector that every x86-64 processor handles at once, aligned like a double. It is the same in every source because
/// programs that use the library may be compiled for other processors than the library.
using Pair __attribute__((vector_size(16), aligned(8), may_alias)) = double;

template <int N, bool Even = N % 2 == 0>
struct DerivativeStorage {
  static constexpr int count = N / 2;
  Pair packs[count] = {};
};
template <int N>
struct DerivativeStorage<N, false> {
  static constexpr int count = N;
  double packs[count] = {};
};

}  // namespace duals

/// N numbers, contiguous in memory on every processor.
template <int N>
class Derivatives {
 public:
  static constexpr std::size_t size() { return N; }
  double& operator[](std::size_t i) { return begin()[i]; }
  double operator[](std::size_t i) const { return begin()[i]; }
  double* begin() { return reinterpret_cast<double*>(storage_.packs); }
  double* end() { return begin() + N; }
  const double* begin() const { return reinterpret_cast<const double*>(storage_.packs); }
  const double* end() const { return begin() + N; }

  Derivatives& operator+=(const Derivatives& b) { return *this = *this + b; }
  Derivatives& operator-=(const Derivatives& b) { return *this = *this - b; }
  friend Derivatives operator+(const Derivatives& a, const Derivatives& b) {
    return elementwise([&](int i) { return a.storage_.packs[i] + b.storage_.packs[i]; });
  }
  friend Derivatives operator-(const Derivatives& a, const Derivatives& b) {
    return elementwise([&](int i) { return a.storage_.packs[i] - b.storage_.packs[i]; });
  }
  friend Derivatives operator*(const Derivatives& a, double b) {
    return elementwise([&](int i) { return a.storage_.packs[i] * b; });
  }
  friend Derivatives operator*(double a, const Derivatives& b) { return b * a; }
  friend Derivatives operator/(const Derivatives& a, double b) {
    return elementwise([&](int i) { return a.storage_.packs[i] / b; });
  }

 private:
  template <class Function>
  static Derivatives elementwise(const Function& function) {
    return expand(function, std::make_integer_sequence<int, duals::DerivativeStorage<N>::count>());
  }
  // Not a loop: compilers keep the array of a loop in memory but this expansion in registers.
  template <class Function, int... I>
  static Derivatives expand(const Function& function, std::integer_sequence<int, I...>) {
    Derivatives out;
    ((out.storage_.packs[I] = function(I)), ...);
    return out;
  }

  duals::DerivativeStorage<N> storage_;
};

/// A value and its derivatives with respect to N numbers.
template <int N>
struct Dual {
  double value = 0;
  Derivatives<N> d;  ///< one per variable

  Dual() = default;
  Dual(double constant) : value(constant) {}  // NOLINT(google-explicit-constructor): plain numbers are constants
  /// The k-th variable of differentiation.
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
  // Builds the result directly: adding to a copy would pass it through memory twice.
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

/// f(x), given the value and derivative of f at x.
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
/// At zero, where the root is not differentiable, the derivatives are zero: this suits a length that vanishes
/// identically in a neighbourhood.
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
/// x raised to a constant power.
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

/// Lets Eigen vectors and matrices hold dual numbers.
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
