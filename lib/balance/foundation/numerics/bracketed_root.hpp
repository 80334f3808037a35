#pragma once
/// A root of a continuous function between two arguments at which its signs differ, by Brent's method (R. P. Brent,
/// Algorithms for Minimization Without Derivatives, 1973, ch. 4).

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace balance::numerics {

/// @param f evaluated between a and b only
/// @param fa, fb its values there, of different signs or zero
/// @param relative_tolerance of the root's position; at least the round-off
/// @param max_evaluations of f
template <class Function>
double find_bracketed_root(Function&& f, double a, double b, double fa, double fb, double relative_tolerance,
                           int max_evaluations = 200) {
  // b is the best estimate, a the one before it, and the root is between b and c
  double c = a, fc = fa, step = b - a, last_step = step;
  for (int i = 0; i < max_evaluations && fb != 0; ++i) {
    if ((fb > 0) == (fc > 0)) c = a, fc = fa, step = last_step = b - a;
    if (std::abs(fc) < std::abs(fb)) a = b, b = c, c = a, fa = fb, fb = fc, fc = fa;
    const double tolerance =
        std::max(2 * std::numeric_limits<double>::epsilon(), relative_tolerance / 2) * std::abs(b) +
        std::numeric_limits<double>::min();
    const double middle = (c - b) / 2;
    if (std::abs(middle) <= tolerance) break;
    if (std::abs(last_step) < tolerance || std::abs(fa) <= std::abs(fb)) {
      step = last_step = middle;
    } else {  // the secant, or the inverse parabola through three points
      const double s = fb / fa;
      double p, q;
      if (a == c) {
        p = 2 * middle * s;
        q = 1 - s;
      } else {
        const double u = fa / fc, r = fb / fc;
        p = s * (2 * middle * u * (u - r) - (b - a) * (r - 1));
        q = (u - 1) * (r - 1) * (s - 1);
      }
      if (p > 0) q = -q;
      p = std::abs(p);
      const bool is_within = 2 * p < std::min(3 * middle * q - std::abs(tolerance * q), std::abs(last_step * q));
      last_step = is_within ? std::exchange(step, p / q) : (step = middle);
    }
    a = b, fa = fb;
    b += std::abs(step) > tolerance ? step : std::copysign(tolerance, middle);
    fb = f(b);
  }
  return b;
}

}  // namespace balance::numerics
