#pragma once
/// One step of an ordinary differential equation to nearly full precision: Gragg's modified midpoint rule with 2, 4, 6,
/// … substeps, extrapolated to substeps of zero length (Hairer, Nørsett and Wanner, Solving Ordinary Differential
/// Equations I, section II.9).

#include "balance/foundation/base/types.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace balance::numerics {

/// @param rates rates(time, y, dy): false if undefined
/// @param dy rates at the start of the step
/// @param y at the start, on return at the end
/// @param scale magnitude of each component
/// @param tolerance of the error of a component, relative to its scale or its value, whichever is larger
/// @return false if the tolerance is not met or rates are undefined on the way: a shorter step may help
template <class Rates>
bool step_by_extrapolation(const Rates& rates, double time, double step, const VectorX& dy, const VectorX& scale,
                           double tolerance, VectorX& y) {
  constexpr int max_extrapolation_columns = 9;
  std::array<VectorX, max_extrapolation_columns> table;  // the last row of the tableau, T(k, 0) to T(k, k)
  VectorX rate(y.size());
  for (int k = 0; k < max_extrapolation_columns; ++k) {
    const int substeps = 2 * (k + 1);
    const double h = step / substeps;
    VectorX previous = y, current = y + h * dy;
    for (int i = 1; i < substeps; ++i) {
      if (!rates(time + i * h, current, rate)) return false;
      const VectorX next = previous + 2 * h * rate;
      previous = current;
      current = next;
    }
    if (!rates(time + step, current, rate)) return false;
    VectorX entry = (current + previous + h * rate) / 2;
    for (int j = 1; j <= k; ++j) {
      const double ratio = static_cast<double>(k + 1) / (k + 1 - j);
      const VectorX extrapolated = entry + (entry - table[static_cast<std::size_t>(j - 1)]) / (ratio * ratio - 1);
      table[static_cast<std::size_t>(j - 1)] = entry;
      entry = extrapolated;
    }
    const auto last = static_cast<std::size_t>(std::max(0, k - 1));
    const bool has_converged =
        k > 1 && entry.allFinite() &&
        ((entry - table[last]).array().abs() <= tolerance * scale.array().max(entry.array().abs())).all();
    table[static_cast<std::size_t>(k)] = entry;
    if (!has_converged) continue;
    y = entry;
    return true;
  }
  return false;
}

}  // namespace balance::numerics
