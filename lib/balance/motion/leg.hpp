#pragma once
/// What a schedule is made of: legs, each a clock, a curve and a rotation.

#include "balance/motion/clock.hpp"
#include "balance/motion/curve.hpp"
#include "balance/motion/schedule.hpp"
#include "balance/motion/turn.hpp"

#include <vector>

namespace balance {

/// Times nearer than this part of the whole duration are the same time: some thousand ulp, far below any sampling.
inline constexpr double time_tolerance = 1e-12;

struct PathSegment {
  TimeScaling time_scaling;
  Curve curve;
  RotationCurve rotation;
};

struct SegmentedPath {
  double duration = 0;                ///< [s]
  int size = 0;                       ///< scalar components
  std::vector<PathSegment> segments;  ///< in order of time, at least one
};

/// @throws std::invalid_argument as Schedule's constructor does
SegmentedPath make_segmented_path(const PrescribedMotion::Request& request);

/// When each waypoint is passed, in order, the start (0) and the end (1) included.
/// @param points start, waypoints, end
/// @param fractions those of the waypoints; empty: by the length of the chords between the points
std::vector<double> compute_waypoint_fractions(const std::vector<DriveValue>& points,
                                               const std::vector<double>& fractions, int position_components,
                                               bool turns);

}  // namespace balance
