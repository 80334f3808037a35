#include "balance/motion/control/sensor.hpp"

#include "balance/foundation/base/elementary.hpp"

#include <cmath>

namespace balance::control {

Sensor::Sensor(const study::Measurement& measurement, double period)
    : measurement_(measurement), period_(period), random_(measurement.seed) {}

/// Standard normal, by Marsaglia's polar method: std::normal_distribution differs between libraries.
double Sensor::draw_standard_normal() {
  if (has_cached_normal_) {
    has_cached_normal_ = false;
    return cached_normal_;
  }
  double x, y, squared_radius;
  do {
    x = random_(-1, 1);
    y = random_(-1, 1);
    squared_radius = x * x + y * y;
  } while (squared_radius >= 1 || squared_radius == 0);
  const double factor = std::sqrt(-2 * elementary::log(squared_radius) / squared_radius);
  cached_normal_ = factor * y;
  has_cached_normal_ = true;
  return factor * x;
}

void Sensor::read(const VectorX& position, const VectorX& velocity, const VectorX& first_rate) {
  position_ = position;
  velocity_ = velocity;
  const study::Measurement& m = measurement_;
  for (Eigen::Index a = 0; a < position.size(); ++a) {
    if (m.position_noise.size() > 0) position_[a] += m.position_noise[a] * draw_standard_normal();
    if (m.position_step.size() > 0 && m.position_step[a] > 0)
      position_[a] = m.position_step[a] * std::round(position_[a] / m.position_step[a]);
    if (m.velocity_noise.size() > 0) velocity_[a] += m.velocity_noise[a] * draw_standard_normal();
  }
  if (m.velocity == study::VelocitySource::difference)
    velocity_ = is_first_reading_ ? first_rate : VectorX((position_ - previous_position_) / period_);
  previous_position_ = position_;
  is_first_reading_ = false;
}

}  // namespace balance::control
