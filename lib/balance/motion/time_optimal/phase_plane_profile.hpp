#pragma once
/// A motion along the path at the edge of what the limits allow.

#include "balance/mechanics/trajectory/motion_law.hpp"
#include "balance/motion/time_optimal/acceleration_limits.hpp"

#include <functional>
#include <vector>

namespace balance {

/// A moment of it.
struct ProfilePoint {
  double t = 0;  ///< from the arc's start [s]
  double s = 0, v = 0;
  double u = 0;  ///< s''
  int row = -1;  ///< which limit it is at; −1: none
};

/// Ascending in t and s.
using VelocityProfile = std::vector<ProfilePoint>;

/// Place, rate and second rate between two nodes, by the quintic that the law will be.
ProfilePoint interpolate(const ProfilePoint& a, const ProfilePoint& b, double t);
/// The same at a place.
ProfilePoint interpolate_at_parameter(const ProfilePoint& a, const ProfilePoint& b, double s);

enum class ProfileKind {
  accelerate,  ///< the largest s'', forwards in time
  decelerate,  ///< the smallest s'', backwards in time
  slide,       ///< on the cap of a row without a, forwards
};

enum class IntegrationEnd {
  reached_target,       ///< at the place that it was to go to
  infeasible,           ///< nothing is allowed any more
  hit_velocity_bound,   ///< on the cap, exactly
  left_velocity_bound,  ///< a slide: the cap can be followed no further, s'' has to be smaller than it asks for
  stopped_by_callback,  ///< by the watcher
  unbounded,            ///< nothing limits s''
  infeasible_start,     ///< s' does not leave zero
};

/// A stretch of the path where everything is smooth.
struct SmoothInterval {
  double begin = 0, end = 1;
  std::size_t first_panel = 0, last_panel = 1;
  bool has_zero_inertia_begin = false, has_zero_inertia_end = false;  ///< a row's a

  /// How near arcs come to such an end: on it nothing can be asked of that row.
  double inner_begin() const { return has_zero_inertia_begin ? begin + margin() : begin; }
  double inner_end() const { return has_zero_inertia_end ? end - margin() : end; }

 private:
  double margin() const { return 1e-6 * (end - begin); }
};

/// Sees every step; true: enough.
using StepCallback = std::function<bool(const ProfilePoint& from, const ProfilePoint& to)>;

/// Continues an arc by embedded Runge–Kutta steps in time (Dormand and Prince), so short that the quintics between nodes keep s''.
/// @param arc at least one node, on the stretch; braking: nodes run backwards, t counts backwards from the arc's first node
/// @param until within the stretch
/// @param under not 0: the ceiling, less this part of it, is taken for a cap, too
IntegrationEnd integrate_profile(AccelerationLimits& allowed, const SmoothInterval& stretch, ProfileKind edge,
                                 double until, const StepCallback& watcher, VelocityProfile& arc, double under = 0);

// A leg of the path between its stations, and steps from a place where a row's a vanishes.

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
