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
  explicit ToleranceSampler(std::uint64_t seed) : bits_(seed) {}

  /// By how much the number is off.
  double draw(const ToleranceNumber& number) { return draw(number.spread, number.width); }
  /// The same of a number whose deviation is 1.
  double draw_standard(Spread spread) { return draw(spread, spread == Spread::uniform ? std::numbers::sqrt3 : 1); }

 private:
  double draw(Spread spread, double width) {
    if (spread == Spread::uniform) return width * (2 * unit() - 1);
    // Box and Muller; the second of the pair is left.
    const double radius = std::sqrt(-2 * elementary::log1p(-unit()));
    return width * radius * elementary::cos(2 * std::numbers::pi * unit());
  }

  /// In [0, 1).
  double unit() { return static_cast<double>(bits_() >> 11) * 0x1p-53; }

  std::mt19937_64 bits_;
};

}  // namespace balance
