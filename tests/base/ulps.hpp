#pragma once

#include <algorithm>
#include <cfloat>
#include <cmath>

/// Distance in units in the last place of the double nearest to the true value.
inline double ulps(double found, long double exact) {
  int exponent;
  std::frexp(static_cast<double>(exact), &exponent);
  return static_cast<double>(std::abs(found - exact) / std::ldexp(1.0L, std::max(exponent, -1000) - DBL_MANT_DIG));
}
