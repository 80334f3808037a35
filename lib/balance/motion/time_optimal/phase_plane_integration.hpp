#pragma once
/// The rates from which the end of a leg can be reached within the limits.

#include "balance/motion/time_optimal/phase_plane_profile.hpp"

#include <string>
#include <vector>

namespace balance::time_optimal {

/// A deceleration profile that bounds the rate, up to where it leaves the maximum velocity curve or the leg ends.
struct DecelerationProfile {
  VelocityProfile points;     ///< in increasing order; t from its first node
  int zero_inertia_row = -1;  ///< the row of zero inertia at its end; −1: none

  double begin() const { return points.front().s; }
  double end() const { return points.back().s; }
};

/// Between two profiles the bound is the maximum velocity curve.
struct ControllableSet {
  std::vector<DecelerationProfile> profiles;  ///< in increasing order; the last one ends with the leg
  std::string refusal;                        ///< why there are none; empty if there are

  /// The profile that contains a path parameter; null if there is none.
  const DecelerationProfile* profile_at(double s) const;
};

/// @param end_rate s' at the end of the leg
ControllableSet compute_controllable_set(AccelerationLimits& limits, const SegmentRange& leg, double end_rate);

/// Point of a profile at a path parameter that it contains.
ProfilePoint interpolate_profile(const VelocityProfile& profile, double s);

/// "at 30 % of the path".
std::string format_path_parameter(double s);

}  // namespace balance::time_optimal
