#pragma once
/// Random values of numbers that may be off, the same with every standard library. Private to analysis.

#include "balance/base/elementary.hpp"
#include "balance/study/tolerances.hpp"

#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>

namespace balance {

class ToleranceSampler {
 public:
  explicit ToleranceSampler(std::uint64_t seed) : generator_(seed) {}

  /// By how much the number is off.
  double draw(const TolerancedParameter& number) { return draw(number.distribution, number.width); }
  /// The same of a number whose deviation is 1.
  double draw_standard(Distribution spread) {
    return draw(spread, spread == Distribution::uniform ? std::numbers::sqrt3 : 1);
  }

 private:
  double draw(Distribution spread, double width) {
    if (spread == Distribution::uniform) return width * (2 * draw_uniform() - 1);
    // Box and Muller; the second of the pair is left.
    const double radius = std::sqrt(-2 * elementary::log1p(-draw_uniform()));
    return width * radius * elementary::cos(2 * std::numbers::pi * draw_uniform());
  }

  /// In [0, 1).
  double draw_uniform() { return static_cast<double>(generator_() >> 11) * 0x1p-53; }

  std::mt19937_64 generator_;
};

}  // namespace balance
