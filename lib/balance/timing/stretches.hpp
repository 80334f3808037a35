#pragma once
/// A leg of the path between its stations, and steps from a place where a row's a vanishes. Private to timing.

#include "balance/timing/arc.hpp"

#include <vector>

namespace balance {

/// From rest to rest (or from and to stated speeds), cut into smooth stretches.
struct SegmentRange {
  double begin = 0, end = 1;
  std::vector<SmoothInterval> smooth_intervals;  ///< in order
};

std::vector<SegmentRange> split_into_segments(const PathModel& model);

/// The arcs through a point of zero inertia (docs/motion.md, section 3): there the row's bound decides s'' by its slope.
class ZeroInertia {
 public:
  /// What is known of such a place on one side of it.
  struct Start {
    bool is_feasible = false;
    bool is_on_row = false;                ///< on the row's own arc; else by the other rows
    double u = 0, acceleration_slope = 0;  ///< s'' and its derivative with respect to s
  };

  /// @param allowed at the station, its inertia dropped @param x where the row ends the speed
  /// @param side −1: braking into the place, 1: speeding up out of it
  static Start profile_start(const AccelerationLimits& allowed, int row, double x, int side);
};

/// First steps of an arc along the row of zero inertia.
/// @param arc the node at the station; gains one more
/// @return whether the row is really what limits there
bool step_from_zero_inertia(AccelerationLimits& allowed, const SmoothInterval& stretch, const ZeroInertia::Start& start,
                            int row, int side, VelocityProfile& arc);

}  // namespace balance
