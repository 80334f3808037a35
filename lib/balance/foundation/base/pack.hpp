#pragma once
/// Several numbers processed as one: the scalar for computing many samples at once. Lane l holds the number of sample
/// l. Every operation follows IEEE 754 in every lane, so that a lane's result depends neither on its neighbours nor on
/// the number of lanes. Sources that use packs are compiled with -ffp-contract=off (cmake/Lanes.cmake).

#include "balance/foundation/base/elementary.hpp"
#include "balance/foundation/base/types.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#ifdef __SSE2__
#include <immintrin.h>
#endif

namespace balance {

namespace packs {

// Aligned no more strictly than Eigen aligns what it stores. Spelt out because GCC 12 loses constructors from a vector
// whose size depends on a template parameter.
template <int W>
struct Vectors;
#define BALANCE_VECTORS(W)                                                              \
  template <>                                                                           \
  struct Vectors<W> {                                                                   \
    using Numbers __attribute__((vector_size(8 * (W)), aligned(16))) = double;          \
    using Bits __attribute__((vector_size(8 * (W)), aligned(16))) = long long;          \
    using Stored __attribute__((vector_size(8 * (W)), aligned(8), may_alias)) = double; \
  };
BALANCE_VECTORS(2)
BALANCE_VECTORS(4)
BALANCE_VECTORS(8)
#undef BALANCE_VECTORS

// Correctly rounded, like std::sqrt; intrinsics where a loop would process the lanes one by one.
template <class Numbers>
Numbers sqrt_lanes(const Numbers& x) {
  Numbers out;
  for (unsigned l = 0; l < sizeof x / sizeof x[0]; ++l) out[l] = std::sqrt(x[l]);
  return out;
}
#ifdef __SSE2__
inline Vectors<2>::Numbers sqrt_lanes(const Vectors<2>::Numbers& x) { return _mm_sqrt_pd(x); }
#endif
#ifdef __AVX__
inline Vectors<4>::Numbers sqrt_lanes(const Vectors<4>::Numbers& x) { return _mm256_sqrt_pd(x); }
#endif
#ifdef __AVX512F__
inline Vectors<8>::Numbers sqrt_lanes(const Vectors<8>::Numbers& x) { return _mm512_maskz_sqrt_pd(0xff, x); }
#endif

// Whether any lane is true: a single test if the processor has one.
template <class Bits>
bool any_lane(const Bits& bits) {
  long long combined = 0;
  for (unsigned l = 0; l < sizeof bits / sizeof bits[0]; ++l) combined |= bits[l];
  return combined != 0;
}
#ifdef __SSE2__
inline bool any_lane(const Vectors<2>::Bits& bits) { return _mm_movemask_pd((__m128d)bits) != 0; }
#endif
#ifdef __AVX__
inline bool any_lane(const Vectors<4>::Bits& bits) { return _mm256_movemask_pd((__m256d)bits) != 0; }
#endif
#ifdef __AVX512F__
inline bool any_lane(const Vectors<8>::Bits& bits) { return _mm512_test_epi64_mask((__m512i)bits, (__m512i)bits) != 0; }
#endif

}  // namespace packs

/// One boolean per lane.
template <int W>
struct Mask {
  using Bits = typename packs::Vectors<W>::Bits;
  Bits bits;  ///< per lane: all bits set or none

  bool operator[](int lane) const { return bits[lane] != 0; }
  /// True if all lanes are true: for branches on conditions that agree in all lanes.
  explicit operator bool() const { return all(*this); }
  friend Mask operator&(const Mask& a, const Mask& b) { return {a.bits & b.bits}; }
  friend Mask operator|(const Mask& a, const Mask& b) { return {a.bits | b.bits}; }
  friend Mask operator!(const Mask& a) { return {~a.bits}; }
  friend bool any(const Mask& a) { return packs::any_lane(a.bits); }
  friend bool all(const Mask& a) { return !any(!a); }
};

template <int W>
struct Pack {
  using Numbers = typename packs::Vectors<W>::Numbers;
  using Bits = typename packs::Vectors<W>::Bits;
  static constexpr int lanes = W;
  Numbers v;

  Pack() = default;                          ///< uninitialised, like a double
  Pack(double x) : v(x - Numbers{}) {}       ///< the same number in every lane
  explicit Pack(const Numbers& x) : v(x) {}  ///< lane by lane
  // Not memcpy: the compiler copies in halves, which the processor must then wait for.
  static Pack load(const double* numbers) {
    return Pack(Numbers(*reinterpret_cast<const typename packs::Vectors<W>::Stored*>(numbers)));
  }
  void store(double* numbers) const { *reinterpret_cast<typename packs::Vectors<W>::Stored*>(numbers) = v; }
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

  // False in a lane with NaN, like a comparison of doubles; != is true there.
  friend Mask<W> operator<(const Pack& a, const Pack& b) { return {(Bits)(a.v < b.v)}; }
  friend Mask<W> operator<=(const Pack& a, const Pack& b) { return {(Bits)(a.v <= b.v)}; }
  friend Mask<W> operator>(const Pack& a, const Pack& b) { return {(Bits)(a.v > b.v)}; }
  friend Mask<W> operator>=(const Pack& a, const Pack& b) { return {(Bits)(a.v >= b.v)}; }
  friend Mask<W> operator==(const Pack& a, const Pack& b) { return {(Bits)(a.v == b.v)}; }
  friend Mask<W> operator!=(const Pack& a, const Pack& b) { return {(Bits)(a.v != b.v)}; }

  friend Pack select(const Mask<W>& mask, const Pack& a, const Pack& b) { return Pack(mask.bits ? a.v : b.v); }
  // With NaN they return the first argument, like std::min and std::max.
  friend Pack min(const Pack& a, const Pack& b) { return select(b < a, b, a); }
  friend Pack max(const Pack& a, const Pack& b) { return select(a < b, b, a); }
  friend Pack abs(const Pack& a) { return Pack((Numbers)((Bits)a.v & 0x7fffffffffffffffLL)); }
  /// Moves every lane to the next one; the first lane becomes `first`.
  friend Pack shift_lanes(const Pack& a, double first) {
    Pack out;
    out.v[0] = first;
    for (int l = 1; l < W; ++l) out.v[l] = a.v[l - 1];
    return out;
  }
  friend double reduce_min(const Pack& a) {
    double smallest = a.v[0];
    for (int l = 1; l < W; ++l) smallest = a.v[l] < smallest ? a.v[l] : smallest;
    return smallest;
  }
  friend Pack sqrt(const Pack& a) { return Pack(packs::sqrt_lanes(a.v)); }
};

// So that code written for packs also works with single numbers.
inline bool any(bool a) { return a; }
inline bool all(bool a) { return a; }
inline double select(bool mask, double a, double b) { return mask ? a : b; }

/// Number of lanes of the instruction set that a source is compiled for.
#if defined(__AVX512F__)
inline constexpr int native_lanes = 8;
#elif defined(__AVX2__)
inline constexpr int native_lanes = 4;
#else
inline constexpr int native_lanes = 2;
#endif

/// Sine and cosine of every lane, bit-identical to those of a single number.
template <int W>
inline SineCosine<Pack<W>> sine_cosine(const Pack<W>& x) {
  using P = Pack<W>;
  auto reduced = sines::reduce_cody_waite<typename P::Numbers, typename P::Bits>(x.v);
  const Mask<W> small = abs(x) <= sines::max_cody_waite_argument;
  if (!all(small)) {
    for (int l = 0; l < W; ++l) {
      if (small[l]) continue;
      const auto lane = sines::reduce_payne_hanek(x[l]);
      reduced.y[l] = lane.y, reduced.t[l] = lane.t, reduced.quadrant[l] = lane.quadrant;
    }
  }
  const auto sc = sines::sine_cosine_of_reduced(reduced);
  return {P(sc.sine), P(sc.cosine)};
}

/// The overload that the recursions call.
template <int W>
inline void sine_cosine_into(const Pack<W>& x, Pack<W>& sine, Pack<W>& cosine) {
  const auto sc = sine_cosine(x);
  sine = sc.sine, cosine = sc.cosine;
}

}  // namespace balance

// Packs as scalars of small Eigen vectors and matrices, mixed with numbers that are the same in every lane.

/// Prevents a pack from crossing a cache line, which would cost two reads.
template <int W>
inline constexpr std::size_t balance::storage_alignment<balance::Pack<W>> = sizeof(double) * W;

/// All lanes share one mechanism, so its parameters are plain numbers.
template <int W>
struct balance::ModelScalarTraits<balance::Pack<W>> {
  using Type = double;
};

template <int W>
struct Eigen::NumTraits<balance::Pack<W>> : Eigen::NumTraits<double> {
  using Real = balance::Pack<W>;
  using NonInteger = balance::Pack<W>;
  using Nested = balance::Pack<W>;
  using Literal = balance::Pack<W>;
};

template <int W, class Operation>
struct Eigen::ScalarBinaryOpTraits<balance::Pack<W>, double, Operation> {
  using ReturnType = balance::Pack<W>;
};
template <int W, class Operation>
struct Eigen::ScalarBinaryOpTraits<double, balance::Pack<W>, Operation> {
  using ReturnType = balance::Pack<W>;
};

namespace balance {

// Square matrices whose rows are packs.

namespace packs {

// One stage of a transposition: a and b are rows i and i + D; they exchange alternate groups of D columns.
template <int D, int W, int... Lane>
void exchange(Pack<W>& a, Pack<W>& b, std::integer_sequence<int, Lane...>) {
  const Pack<W> first(__builtin_shufflevector(a.v, b.v, (Lane & D ? W + Lane - D : Lane)...));
  b.v = __builtin_shufflevector(a.v, b.v, (Lane & D ? W + Lane : Lane + D)...);
  a = first;
}

template <int D, int W>
inline void transpose_stage(Pack<W> (&rows)[W]) {
  for (int i = 0; i < W; ++i)
    if ((i & D) == 0) exchange<D>(rows[i], rows[i + D], std::make_integer_sequence<int, W>());
  if constexpr (2 * D < W) transpose_stage<2 * D>(rows);
}

}  // namespace packs

/// rows[i][j] becomes rows[j][i].
template <int W>
inline void transpose(Pack<W> (&rows)[W]) {
  packs::transpose_stage<1>(rows);
}

}  // namespace balance
