#pragma once
/// Intervals: bounds between which a real number certainly lies. Every operation is computed in the processor's usual
/// rounding and then widened by more than its error, so that no rounding mode is changed and compilers may reorder as
/// they like.
///
/// Proof of the widening: a sum, difference, product, quotient or root x computed by IEEE 754 differs from the exact
/// value by at most u|x| + η, with u = 2⁻⁵³ and η below the smallest normal number, in any order of minimum and maximum.
/// `outward_margin` is 4u|x| + 10⁻³⁰⁰; subtracting it rounds by at most u|x|(1 + 4u) again, which leaves 2u|x|.
///
/// Bounds are always finite: an operation whose result is not, or exceeds `max_interval_magnitude`, throws. So no NaN
/// can arise that a comparison would overlook.

#include "balance/foundation/base/elementary.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace balance {

/// A quotient by an interval that contains zero, a root of a negative number, or too large a number: nothing can be said
/// about the result.
class EnclosureError : public std::domain_error {
 public:
  using std::domain_error::domain_error;
};

inline constexpr double max_interval_magnitude = 1e150;

[[noreturn, gnu::noinline, gnu::cold]] inline void throw_unbounded() {
  throw EnclosureError("an interval is not bounded");
}

inline double outward_margin(double x) { return std::abs(x) * 0x1p-51 + 1e-300; }

/// lower ≤ x ≤ upper.
struct Interval {
  double lower, upper;

  Interval() : lower(0), upper(0) {}
  Interval(double value) : lower(value), upper(value) {}  // NOLINT(google-explicit-constructor): numbers are intervals
  Interval(double low, double high) : lower(low), upper(high) {}
  /// Bounds that were computed, widened by the error of their last operation.
  [[gnu::always_inline]] static Interval widened(double low, double high) {
    if (!(low > -max_interval_magnitude && high < max_interval_magnitude)) throw_unbounded();
    return {low - outward_margin(low), high + outward_margin(high)};
  }

  double middle() const { return 0.5 * (lower + upper); }
  double width() const { return upper - lower; }
  /// Largest absolute value.
  double magnitude() const { return std::max(-lower, upper); }
  bool is_point() const { return lower == upper; }
  bool contains(double x) const { return lower <= x && x <= upper; }
  bool is_inside(const Interval& b) const { return b.lower < lower && upper < b.upper; }

  friend Interval operator+(const Interval& a, const Interval& b) {
    return widened(a.lower + b.lower, a.upper + b.upper);
  }
  friend Interval operator-(const Interval& a, const Interval& b) {
    return widened(a.lower - b.upper, a.upper - b.lower);
  }
  friend Interval operator-(const Interval& a) { return {-a.upper, -a.lower}; }
  friend Interval operator*(const Interval& a, const Interval& b) {
    const double p = a.lower * b.lower, q = a.lower * b.upper, r = a.upper * b.lower, s = a.upper * b.upper;
    return widened(std::min(std::min(p, q), std::min(r, s)), std::max(std::max(p, q), std::max(r, s)));
  }
  friend Interval operator*(const Interval& a, double b) {
    const double p = a.lower * b, q = a.upper * b;
    return widened(std::min(p, q), std::max(p, q));
  }
  friend Interval operator*(double a, const Interval& b) { return b * a; }
  Interval& operator+=(const Interval& b) { return *this = *this + b; }
  Interval& operator-=(const Interval& b) { return *this = *this - b; }
};

/// 1 / x. @throws EnclosureError if x contains zero
inline Interval inverse(const Interval& x) {
  if (!(x.lower > 0 || x.upper < 0)) throw EnclosureError("a divisor may vanish");
  return Interval::widened(1 / x.upper, 1 / x.lower);
}
inline Interval operator/(const Interval& a, const Interval& b) { return a * inverse(b); }

inline Interval square(const Interval& x) {
  const double low = x.lower > 0 ? x.lower : x.upper < 0 ? x.upper : 0, high = x.magnitude();
  const Interval result = Interval::widened(low * low, high * high);
  return {std::max(0.0, result.lower), result.upper};
}

/// @throws EnclosureError if x may be negative
inline Interval sqrt(const Interval& x) {
  if (!(x.lower >= 0)) throw EnclosureError("a root of a number that may be negative");
  const Interval result = Interval::widened(std::sqrt(x.lower), std::sqrt(x.upper));
  return {std::max(0.0, result.lower), result.upper};
}

/// The numbers in both. @throws EnclosureError if there are none, which shows that one of them encloses nothing
inline Interval intersect(const Interval& a, const Interval& b) {
  const Interval result{std::max(a.lower, b.lower), std::min(a.upper, b.upper)};
  if (!(result.lower <= result.upper)) throw EnclosureError("enclosures do not meet");
  return result;
}

namespace intervals {

/// Of sine and cosine, whose error is below 0.8 units in the last place of numbers up to 1.
inline constexpr double sine_margin = 0x1p-51;
/// Relative to a turn: by how much the place of an extremum is known.
inline constexpr double extremum_margin = 1e-9;
inline constexpr double turn = 6.283185307179586;

/// Whether x contains a number first + k turns. True in doubt.
inline bool may_contain_angle(const Interval& x, double first) {
  const double low = (x.lower - first) / turn - extremum_margin, high = (x.upper - first) / turn + extremum_margin;
  return std::floor(high) >= std::ceil(low);
}

/// @param f sine or cosine @param maximum an angle at which it is 1
template <class Function>
Interval enclose_wave(const Interval& x, const Function& f, double maximum) {
  if (!(x.magnitude() <= sines::max_cody_waite_argument)) throw EnclosureError("an angle is too large");
  const double a = f(x.lower), b = f(x.upper);
  Interval result{std::min(a, b) - sine_margin, std::max(a, b) + sine_margin};
  if (x.lower == x.upper) return result;
  if (may_contain_angle(x, maximum)) result.upper = 1;
  if (may_contain_angle(x, maximum + 0.5 * turn)) result.lower = -1;
  return result;
}

}  // namespace intervals

inline Interval sin(const Interval& x) { return intervals::enclose_wave(x, elementary::sin, 0.25 * intervals::turn); }
inline Interval cos(const Interval& x) { return intervals::enclose_wave(x, elementary::cos, 0); }

}  // namespace balance
