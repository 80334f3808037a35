#pragma once
/// The units that a mechanism's designer thinks in, for what is said to him. All numbers are kept in SI.

#include <string>

namespace balance {

struct SpecUnits {
  double length = 1;  ///< [m]
  double angle = 1;   ///< [rad]
  std::string length_name = "m", angle_name = "rad";
};

/// Coordinates of a pose are found no better than this, in radians or characteristic lengths.
inline constexpr double pose_round_off = 1e-12;

/// "350 mm". @param value [m] @param round_off values no larger become 0 [m]
std::string length_text(double value, const SpecUnits& units, double round_off = 0);
/// "120 deg". @param value [rad] @param round_off values no larger become 0 [rad]
std::string angle_text(double value, const SpecUnits& units, double round_off = 0);
/// "(350, 0) mm". @param place its components [m] @param count 2 or 3
std::string place_text(const double* place, int count, const SpecUnits& units, double round_off = 0);

}  // namespace balance
