#pragma once
/// The speeds from which a leg's end can be reached within the limits.

#include "balance/motion/time_optimal/phase_plane_profile.hpp"

#include <string>
#include <vector>

namespace balance {

/// A braking arc that bounds the speeds, up to where it leaves the ceiling of what is allowed at all, or to the leg's end.
struct DecelerationProfile {
  VelocityProfile points;     ///< ascending; t from its first node
  int zero_inertia_row = -1;  ///< the row that vanishes where it ends; −1: none

  double begin() const { return points.front().s; }
  double end() const { return points.back().s; }
};

/// Between two arcs the ceiling is the bound.
struct ControllableSet {
  std::vector<DecelerationProfile> profiles;  ///< ascending, the last one ends with the leg
  std::string refusal;                        ///< why there are none; empty: there are

  /// The arc that holds a place, or nothing.
  const DecelerationProfile* profile_at(double place) const;
};

/// @param end_rate s' at the leg's end
ControllableSet compute_controllable_set(AccelerationLimits& allowed, const SegmentRange& leg, double end_rate);

/// Where an arc stands at a place of its own.
ProfilePoint interpolate_profile(const VelocityProfile& arc, double place);

/// "at 30 % of the path".
std::string format_path_parameter(double place);

}  // namespace balance
