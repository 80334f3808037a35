#pragma once
/// A step of an ordinary differential equation to nearly all digits: Gragg's modified midpoint rule with 2, 4, 6, … parts, extrapolated to
/// parts without length (Hairer, Nørsett and Wanner, Solving Ordinary Differential Equations I, section II.9).

#include "balance/foundation/base/types.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace balance {

/// @param rates rates(time, y, dy): false where there are none
/// @param dy rates at the step's start
/// @param y at the start, on return at the end
/// @param scale per component: what counts as one
/// @param tolerance of the error of a component, in its scale, or as part of its value where that is larger
/// @return false if that is not reached, or rates are missing on the way: a shorter step may help
template <class Rates>
bool step_by_extrapolation(const Rates& rates, double time, double step, const VectorX& dy, const VectorX& scale,
                           double tolerance, VectorX& y) {
  constexpr int max_extrapolation_columns = 9;
  std::array<VectorX, max_extrapolation_columns> table;  // T(k, 0) to T(k, k), row after row in one place
  VectorX slope(y.size());
  for (int k = 0; k < max_extrapolation_columns; ++k) {
    const int parts = 2 * (k + 1);
    const double h = step / parts;
    VectorX before = y, here = y + h * dy;
    for (int i = 1; i < parts; ++i) {
      if (!rates(time + i * h, here, slope)) return false;
      const VectorX next = before + 2 * h * slope;
      before = here;
      here = next;
    }
    if (!rates(time + step, here, slope)) return false;
    VectorX entry = (here + before + h * slope) / 2;
    for (int j = 1; j <= k; ++j) {
      const double ratio = static_cast<double>(k + 1) / (k + 1 - j);
      const VectorX better = entry + (entry - table[static_cast<std::size_t>(j - 1)]) / (ratio * ratio - 1);
      table[static_cast<std::size_t>(j - 1)] = entry;
      entry = better;
    }
    const auto last = static_cast<std::size_t>(std::max(0, k - 1));
    const bool good = k > 1 && entry.allFinite() &&
                      ((entry - table[last]).array().abs() <= tolerance * scale.array().max(entry.array().abs())).all();
    table[static_cast<std::size_t>(k)] = entry;
    if (!good) continue;
    y = entry;
    return true;
  }
  return false;
}

}  // namespace balance
