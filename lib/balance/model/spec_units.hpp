#pragma once
/// The units that a mechanism's designer thinks in, for what is said to him. All numbers are kept in SI.

#include <string>

namespace balance {

struct DisplayUnits {
  double length = 1;  ///< [m]
  double angle = 1;   ///< [rad]
  std::string length_name = "m", angle_name = "rad";
};

/// Coordinates of a pose are found no better than this, in radians or characteristic lengths.
inline constexpr double pose_round_off = 1e-12;

/// "350 mm". @param value [m] @param round_off values no larger become 0 [m]
std::string format_length(double value, const DisplayUnits& units, double round_off = 0);
/// "120 deg". @param value [rad] @param round_off values no larger become 0 [rad]
std::string format_angle(double value, const DisplayUnits& units, double round_off = 0);
/// "(350, 0) mm". @param place its components [m] @param count 2 or 3
std::string format_position(const double* place, int count, const DisplayUnits& units, double round_off = 0);

}  // namespace balance
