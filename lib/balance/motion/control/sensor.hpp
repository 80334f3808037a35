#pragma once
/// Measurements of a controller: quantised, noisy samples. The same seed gives the same numbers on every machine.

#include "balance/foundation/numerics/random.hpp"
#include "balance/motion/study/controller_spec.hpp"

namespace balance::control {

class Sensor {
 public:
  /// @param measurement must outlive the sensor
  /// @param period time between two readings [s]
  Sensor(const study::Measurement& measurement, double period);

  /// One reading of the actuated coordinates.
  /// @param first_rate result of a differentiating sensor before it has two positions: the desired rate
  void read(const VectorX& position, const VectorX& velocity, const VectorX& first_rate);

  const VectorX& position() const { return position_; }
  const VectorX& velocity() const { return velocity_; }

 private:
  double draw_standard_normal();

  const study::Measurement& measurement_;
  double period_;
  numerics::UniformRandom random_;
  double cached_normal_ = 0;
  bool has_cached_normal_ = false;
  bool is_first_reading_ = true;
  VectorX position_, velocity_, previous_position_;
};

}  // namespace balance::control
