#pragma once
/// Joint coordinates as lengths and angles.

#include "balance/model/mechanism.hpp"

#include <cmath>

namespace balance {

inline bool is_length_coordinate(const Mechanism& mechanism, CoordinateId c) {
  return mechanism.coordinates[static_cast<std::size_t>(c)].kind == CoordinateKind::length;
}

/// "120 deg". @param value [rad or m] @param round_off values no larger become 0 [rad or m]
inline std::string format_coordinate(const Mechanism& mechanism, CoordinateId c, double value, double round_off = 0) {
  return is_length_coordinate(mechanism, c) ? format_length(value, mechanism.units, round_off)
                                            : format_angle(value, mechanism.units, round_off);
}

/// Coordinates of a pose that are round-off become 0. @param values of all coordinates @param length characteristic [m]
template <class Values>
void clear_pose_round_off(const Mechanism& mechanism, double length, Values& values) {
  for (std::size_t c = 0; c < mechanism.coordinates.size(); ++c) {
    double& value = values[static_cast<Eigen::Index>(c)];
    if (std::abs(value) < pose_round_off * (is_length_coordinate(mechanism, static_cast<int>(c)) ? length : 1))
      value = 0;
  }
}

}  // namespace balance
