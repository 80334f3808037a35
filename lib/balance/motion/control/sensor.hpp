#pragma once
/// What a controller gets to see: quantised, noisy samples. The same seed gives the same numbers on every machine.

#include "balance/motion/study/controller_spec.hpp"

#include <random>

namespace balance {

class Sensor {
 public:
  /// @param measurement must outlive the sensor
  /// @param period between two readings [s]
  Sensor(const Measurement& measurement, double period);

  /// One reading of the actuated coordinates.
  /// @param first_rate what a differentiating sensor reads before it has two positions: the desired rate
  void read(const VectorX& position, const VectorX& velocity, const VectorX& first_rate);

  const VectorX& position() const { return position_; }
  const VectorX& velocity() const { return velocity_; }

 private:
  double draw_standard_normal();

  const Measurement& measurement_;
  double period_;
  std::mt19937_64 random_;
  double cached_normal_ = 0;
  bool has_spare_ = false;
  bool first_ = true;
  VectorX position_, velocity_, last_;
};

}  // namespace balance
