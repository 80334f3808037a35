#pragma once
/// Motions along the path with s'' at its limits: profiles in the phase plane.

#include "balance/mechanics/trajectory/motion_law.hpp"
#include "balance/motion/time_optimal/acceleration_limits.hpp"

#include <functional>
#include <vector>

namespace balance::time_optimal {

/// A point of a profile.
struct ProfilePoint {
  double t = 0;  ///< from the start of the profile [s]
  double s = 0, v = 0;
  double u = 0;  ///< s''
  int row = -1;  ///< the active limit; −1: none
};

/// In increasing order of t and s.
using VelocityProfile = std::vector<ProfilePoint>;

/// Interpolates between two nodes by the quintic that the law will use.
ProfilePoint interpolate(const ProfilePoint& a, const ProfilePoint& b, double t);
/// The same at a path parameter.
ProfilePoint interpolate_at_parameter(const ProfilePoint& a, const ProfilePoint& b, double s);

enum class ProfileKind {
  accelerate,  ///< maximum s'', forwards in time
  decelerate,  ///< minimum s'', backwards in time
  slide,       ///< on the velocity bound of a row without a, forwards
};

enum class IntegrationEnd {
  reached_target,       ///< at the target parameter
  infeasible,           ///< no s'' is feasible
  hit_velocity_bound,   ///< exactly on the velocity bound
  left_velocity_bound,  ///< while sliding: following the velocity bound would need an s'' above its limit
  stopped_by_callback,  ///< the callback returned true
  unbounded,            ///< no limit bounds s''
  infeasible_start,     ///< s' does not leave zero
};

/// A part of the path on which everything is smooth.
struct SmoothInterval {
  double begin = 0, end = 1;
  std::size_t first_panel = 0, last_panel = 1;
  bool has_zero_inertia_begin = false, has_zero_inertia_end = false;  ///< the a of a row vanishes there

  /// Profiles keep a margin from such an end, where that row gives no s''.
  double inner_begin() const { return has_zero_inertia_begin ? begin + margin() : begin; }
  double inner_end() const { return has_zero_inertia_end ? end - margin() : end; }

 private:
  double margin() const { return 1e-6 * (end - begin); }
};

/// Called for every step; returns true to stop.
using StepCallback = std::function<bool(const ProfilePoint& from, const ProfilePoint& to)>;

/// Continues a profile by embedded Runge–Kutta steps in time (Dormand and Prince), short enough for the quintics
/// between nodes to reproduce s''.
/// @param profile at least one node, on the interval; when decelerating, nodes run backwards and t counts backwards
///        from the first node
/// @param target parameter to reach, within the interval
/// @param velocity_margin if not 0, the maximum velocity curve lowered by this fraction is a velocity bound, too
IntegrationEnd integrate_profile(AccelerationLimits& limits, const SmoothInterval& interval, ProfileKind kind,
                                 double target, const StepCallback& callback, VelocityProfile& profile,
                                 double velocity_margin = 0);

// Legs of the path and their breakpoints, and steps from points at which a row's a vanishes.

/// A leg from rest to rest (or from and to given speeds), split into smooth intervals.
struct SegmentRange {
  double begin = 0, end = 1;
  std::vector<SmoothInterval> smooth_intervals;  ///< in order
};

std::vector<SegmentRange> split_into_segments(const PathModel& model);

/// Profiles through a zero-inertia point (docs/motion.md, section 3). There the slope of the row's bound determines
/// s''.
class ZeroInertia {
 public:
  /// Start of a profile on one side of such a point.
  struct Start {
    bool is_feasible = false;
    bool is_on_row = false;                ///< on the row's own profile; otherwise determined by the other rows
    double u = 0, acceleration_slope = 0;  ///< s'' and its derivative with respect to s
  };

  /// @param limits at the breakpoint, with zero-inertia rows dropped @param x at which the row bounds the rate
  /// @param side −1: decelerating into the point, 1: accelerating out of it
  static Start profile_start(const AccelerationLimits& limits, int row, double x, int side);
};

/// First step of a profile along the row of zero inertia.
/// @param profile ends with the node at the breakpoint; gains another one
/// @return whether the row is the active limit after the step
bool step_from_zero_inertia(AccelerationLimits& limits, const SmoothInterval& interval, const ZeroInertia::Start& start,
                            int row, int side, VelocityProfile& profile);

}  // namespace balance::time_optimal
