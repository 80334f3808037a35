#pragma once
/// Several numbers worked on as one: the scalar of what is computed for many samples at once. Lane l holds the number of sample l.
/// Every operation is IEEE 754's on every lane, so that a lane's result depends neither on its neighbours nor on how many
/// there are. Sources that use packs are compiled with -ffp-contract=off (cmake/Lanes.cmake). Private to the library.

#include <algorithm>
#include <cmath>
#include <cstring>

namespace balance {

namespace packs {

// Spelt out: GCC 12 loses constructors from a vector whose size depends on a template's parameter.
template <int W>
struct Vectors;
#define BALANCE_VECTORS(W)                                      \
  template <>                                                   \
  struct Vectors<W> {                                           \
    using Numbers __attribute__((vector_size(8 * W))) = double; \
    using Bits __attribute__((vector_size(8 * W))) = long long; \
  };
BALANCE_VECTORS(2)
BALANCE_VECTORS(4)
BALANCE_VECTORS(8)
#undef BALANCE_VECTORS

}  // namespace packs

/// A truth for every lane.
template <int W>
struct Mask {
  using Bits = typename packs::Vectors<W>::Bits;
  Bits bits;  ///< of a lane: all set or none

  bool operator[](int lane) const { return bits[lane] != 0; }
  friend Mask operator&(const Mask& a, const Mask& b) { return {a.bits & b.bits}; }
  friend Mask operator|(const Mask& a, const Mask& b) { return {a.bits | b.bits}; }
  friend Mask operator!(const Mask& a) { return {~a.bits}; }
  friend bool any(const Mask& a) {
    long long found = 0;
    for (int l = 0; l < W; ++l) found |= a.bits[l];
    return found != 0;
  }
  friend bool all(const Mask& a) { return !any(!a); }
};

template <int W>
struct Pack {
  using Numbers = typename packs::Vectors<W>::Numbers;
  using Bits = typename packs::Vectors<W>::Bits;
  static constexpr int lanes = W;
  Numbers v;

  Pack() = default;                          ///< undefined, like a double
  Pack(double x) : v(x - Numbers{}) {}       ///< in every lane
  explicit Pack(const Numbers& x) : v(x) {}  ///< lane by lane
  static Pack load(const double* numbers) {
    Pack pack;
    std::memcpy(&pack.v, numbers, sizeof pack.v);
    return pack;
  }
  void store(double* numbers) const { std::memcpy(numbers, &v, sizeof v); }
  double operator[](int lane) const { return v[lane]; }

  Pack& operator+=(const Pack& b) { return v += b.v, *this; }
  Pack& operator-=(const Pack& b) { return v -= b.v, *this; }
  Pack& operator*=(const Pack& b) { return v *= b.v, *this; }
  Pack& operator/=(const Pack& b) { return v /= b.v, *this; }
  friend Pack operator+(const Pack& a, const Pack& b) { return Pack(a.v + b.v); }
  friend Pack operator-(const Pack& a, const Pack& b) { return Pack(a.v - b.v); }
  friend Pack operator*(const Pack& a, const Pack& b) { return Pack(a.v * b.v); }
  friend Pack operator/(const Pack& a, const Pack& b) { return Pack(a.v / b.v); }
  friend Pack operator-(const Pack& a) { return Pack(-a.v); }

  // False where a lane is NaN, like a comparison of doubles; != is true there.
  friend Mask<W> operator<(const Pack& a, const Pack& b) { return {(Bits)(a.v < b.v)}; }
  friend Mask<W> operator<=(const Pack& a, const Pack& b) { return {(Bits)(a.v <= b.v)}; }
  friend Mask<W> operator>(const Pack& a, const Pack& b) { return {(Bits)(a.v > b.v)}; }
  friend Mask<W> operator>=(const Pack& a, const Pack& b) { return {(Bits)(a.v >= b.v)}; }
  friend Mask<W> operator==(const Pack& a, const Pack& b) { return {(Bits)(a.v == b.v)}; }
  friend Mask<W> operator!=(const Pack& a, const Pack& b) { return {(Bits)(a.v != b.v)}; }

  friend Pack select(const Mask<W>& mask, const Pack& a, const Pack& b) { return Pack(mask.bits ? a.v : b.v); }
  // With NaN as std::min and std::max: the first argument.
  friend Pack min(const Pack& a, const Pack& b) { return select(b < a, b, a); }
  friend Pack max(const Pack& a, const Pack& b) { return select(a < b, b, a); }
  friend Pack abs(const Pack& a) { return Pack((Numbers)((Bits)a.v & 0x7fffffffffffffffLL)); }
  friend Pack sqrt(const Pack& a) {
    Pack root;
    for (int l = 0; l < W; ++l) root.v[l] = __builtin_sqrt(a.v[l]);
    return root;
  }
};

// What is written for packs serves a single number as well.
inline bool any(bool a) { return a; }
inline bool all(bool a) { return a; }
inline double select(bool mask, double a, double b) { return mask ? a : b; }

/// How many samples a scalar holds, and one of them.
template <class T>
inline constexpr int lanes_of = T::lanes;
template <>
inline constexpr int lanes_of<double> = 1;

}  // namespace balance
