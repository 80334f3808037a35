#pragma once
/// Derivatives by central differences of the eighth order: of smooth functions, in units of which they change by about
/// their own size, to 1e-13 with a step of 0.02.

#include <array>
#include <cstddef>

namespace balance::vibration {

/// Derivative at 0 of a function from a number to a vector.
template <class Function>
auto differentiate_centrally(const Function& function, double step) {
  constexpr std::array<double, 4> weights{4.0 / 5, -1.0 / 5, 4.0 / 105, -1.0 / 280};
  auto derivative = (weights[0] / step * (function(step) - function(-step))).eval();
  for (std::size_t k = 1; k < weights.size(); ++k) {
    const double shift = step * static_cast<double>(k + 1);
    derivative += weights[k] / step * (function(shift) - function(-shift));
  }
  return derivative;
}

}  // namespace balance::vibration
