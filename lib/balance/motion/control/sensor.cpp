#include "balance/motion/control/sensor.hpp"

#include "balance/foundation/base/elementary.hpp"

#include <cmath>

namespace balance {

Sensor::Sensor(const Measurement& measurement, double period)
    : measurement_(measurement), period_(period), random_(measurement.seed) {}

/// Standard normal, by Marsaglia's polar method: std::normal_distribution differs between libraries.
double Sensor::draw_standard_normal() {
  if (has_spare_) {
    has_spare_ = false;
    return cached_normal_;
  }
  double x, y, square;
  do {
    x = std::ldexp(static_cast<double>(random_() >> 11), -52) - 1;
    y = std::ldexp(static_cast<double>(random_() >> 11), -52) - 1;
    square = x * x + y * y;
  } while (square >= 1 || square == 0);
  const double factor = std::sqrt(-2 * elementary::log(square) / square);
  cached_normal_ = factor * y;
  has_spare_ = true;
  return factor * x;
}

void Sensor::read(const VectorX& position, const VectorX& velocity, const VectorX& first_rate) {
  position_ = position;
  velocity_ = velocity;
  const Measurement& m = measurement_;
  for (Eigen::Index a = 0; a < position.size(); ++a) {
    if (m.position_noise.size() > 0) position_[a] += m.position_noise[a] * draw_standard_normal();
    if (m.position_step.size() > 0 && m.position_step[a] > 0)
      position_[a] = m.position_step[a] * std::round(position_[a] / m.position_step[a]);
    if (m.velocity_noise.size() > 0) velocity_[a] += m.velocity_noise[a] * draw_standard_normal();
  }
  if (m.velocity == VelocitySource::difference)
    velocity_ = first_ ? first_rate : VectorX((position_ - last_) / period_);
  last_ = position_;
  first_ = false;
}

}  // namespace balance
