#pragma once
/// Joint coordinates as lengths and angles.

#include "balance/model/mechanism.hpp"

#include <cmath>

namespace balance {

inline bool is_length(const Mechanism& mechanism, CoordinateId c) {
  return mechanism.coordinates[static_cast<std::size_t>(c)].kind == CoordinateKind::length;
}

/// "120 deg". @param value [rad or m] @param round_off values no larger become 0 [rad or m]
inline std::string coordinate_text(const Mechanism& mechanism, CoordinateId c, double value, double round_off = 0) {
  return is_length(mechanism, c) ? length_text(value, mechanism.units, round_off)
                                 : angle_text(value, mechanism.units, round_off);
}

/// Coordinates of a pose that are round-off become 0. @param values of all coordinates @param length characteristic [m]
template <class Values>
void clear_pose_round_off(const Mechanism& mechanism, double length, Values& values) {
  for (std::size_t c = 0; c < mechanism.coordinates.size(); ++c) {
    double& value = values[static_cast<Eigen::Index>(c)];
    if (std::abs(value) < pose_round_off * (is_length(mechanism, static_cast<int>(c)) ? length : 1)) value = 0;
  }
}

}  // namespace balance
