#pragma once
/// Elementary functions that give the same bits on every machine. Those of the system library choose by processor
/// whether to fuse products with sums, which changes the last digits. IEEE 754 fixes the basic operations, square
/// roots, rounding and remainders; the library calls these functions for everything else. Arguments outside the domain
/// (the logarithm of a negative number) yield NaN.

#include <cstring>

namespace balance {

/// Sine and cosine from IEEE 754 basic operations only: the same bits on every machine and in every lane, independent
/// of the system's math library. Error below 0.8 units in the last place for every finite argument. Lanes:
/// foundation/base/pack.hpp.
/// Source: the reduction of S. Gal, W. Cody and W. Waite with three parts of π/2; polynomials of fdlibm (k_sin.c,
/// k_cos.c).
template <class T>
struct SineCosine {
  T sine, cosine;
};

namespace sines {

/// x = (4 k + quadrant) π/2 + y + t for an integer k, with |y| ≤ π/4 and t below the last place of y. NaN if x is not
/// finite.
template <class Numbers, class Bits>
struct ReducedArgument {
  Numbers y, t;
  Bits quadrant;
};

/// For any x: multiplies by as many digits of 2/π as matter (M. Payne, R. Hanek, 1983).
ReducedArgument<double, long long> reduce_payne_hanek(double x);

inline constexpr double max_cody_waite_argument = 1e5;

template <class To, class From>
inline To bits_as(const From& from) {
  static_assert(sizeof(To) == sizeof(From));
  To to;
  std::memcpy(&to, &from, sizeof to);
  return to;
}

/// For |x| ≤ max_cody_waite_argument: the products with the first two parts of π/2, of 37 bits each, are exact. Takes x
/// by value because a template parameter loses the reduced alignment of a pack.
template <class Numbers, class Bits>
inline ReducedArgument<Numbers, Bits> reduce_cody_waite(Numbers x) {
  const double round = 0x1.8p52;  // the last bits of the sum are the integer
  const Numbers shifted = x * 0x1.45f306dc9c883p-1 + round;
  const Numbers n = shifted - round;
  const Numbers first = x - n * 0x1.921fb5444p+0;
  const Numbers second = n * 0x1.68c234c4cp-39;
  const Numbers high = first - second;
  const Numbers low = n * 0x1.98a2e03707344p-77 - ((first - high) - second);
  const Numbers y = high - low;
  return {y, (high - y) - low, bits_as<Bits>(shifted)};
}

template <class Numbers, class Bits>
inline SineCosine<Numbers> sine_cosine_of_reduced(const ReducedArgument<Numbers, Bits>& reduced) {
  // Each polynomial is split into two halves that do not depend on each other.
  const Numbers y = reduced.y, t = reduced.t, z = y * y, cube = z * y, zz = z * z;
  const Numbers odd_terms =
      (8.33333333332248946124e-03 + z * -1.98412698298579493134e-04) +
      zz * ((2.75573137070700676789e-06 + z * -2.50507602534068634195e-08) + zz * 1.58969099521155010221e-10);
  const Numbers sine = y - ((z * (0.5 * t - cube * odd_terms) - t) + cube * 1.66666666666666324348e-01);
  const Numbers even_terms = z * ((4.16666666666666019037e-02 + z * -1.38888888888741095749e-03) +
                                  zz * ((2.48015872894767294178e-05 + z * -2.75573143513906633035e-07) +
                                        zz * (2.08757232129817482790e-09 + z * -1.13596475577881948265e-11)));
  const Numbers half = 0.5 * z, near = 1.0 - half;
  const Numbers cosine = near + (((1.0 - near) - half) + (z * even_terms - y * t));
  const auto odd = (reduced.quadrant & 1) != 0;
  const Numbers s = odd ? cosine : sine, c = odd ? sine : cosine;
  return {bits_as<Numbers>(bits_as<Bits>(s) ^ ((reduced.quadrant & 2) << 62)),
          bits_as<Numbers>(bits_as<Bits>(c) ^ (((reduced.quadrant + 1) & 2) << 62))};
}

}  // namespace sines

inline SineCosine<double> sine_cosine(double x) {
  return sines::sine_cosine_of_reduced(__builtin_fabs(x) <= sines::max_cody_waite_argument
                                           ? sines::reduce_cody_waite<double, long long>(x)
                                           : sines::reduce_payne_hanek(x));
}

/// In a namespace of their own, so that `using namespace balance` leaves a program's `sin` alone.
namespace elementary {

inline double sin(double x) { return sine_cosine(x).sine; }
inline double cos(double x) { return sine_cosine(x).cosine; }

// Error below 2 units in the last place.
double tan(double x);
double asin(double x);
double acos(double x);
double atan(double x);
double atan2(double y, double x);

// Computed in binary128 and rounded: some microseconds each.
double sinh(double x);
double cosh(double x);
double tanh(double x);
double asinh(double x);
double acosh(double x);
double atanh(double x);
double exp(double x);
double log(double x);
double log10(double x);
double log2(double x);
double log1p(double x);
double pow(double x, double y);

}  // namespace elementary

/// The overload that the recursions call.
inline void sine_cosine_into(double x, double& sine, double& cosine) {
  const auto sc = sine_cosine(x);
  sine = sc.sine, cosine = sc.cosine;
}

}  // namespace balance
