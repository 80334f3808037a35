#pragma once
/// Random numbers that are the same with every standard library, whose own distributions differ.

#include "balance/foundation/base/elementary.hpp"
#include "balance/foundation/base/types.hpp"

#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>

namespace balance::numerics {

class UniformRandom {
 public:
  explicit UniformRandom(std::uint64_t seed) : engine_(seed) {}

  /// Uniform in [lower, upper).
  double operator()(double lower, double upper) {
    return lower + (upper - lower) * static_cast<double>(engine_() >> 11) * 0x1p-53;
  }
  VectorX sample_point(Eigen::Index size, double lower = -1, double upper = 1) {
    VectorX u(size);
    for (double& value : u) value = (*this)(lower, upper);
    return u;
  }
  /// Standard normal, by the method of Box and Muller; the second number of each pair is left.
  VectorX sample_normal(Eigen::Index size) {
    VectorX values(size);
    for (double& value : values) {
      const double radius = std::sqrt(-2 * elementary::log(1 - (*this)(0, 1)));
      value = radius * elementary::cos(2 * std::numbers::pi * (*this)(0, 1));
    }
    return values;
  }

 private:
  std::mt19937_64 engine_;
};

}  // namespace balance::numerics
