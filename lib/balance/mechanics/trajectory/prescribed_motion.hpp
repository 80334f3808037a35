#pragma once
/// The prescribed quantities as functions of time: a path in the drive's components, traversed by a law.

#include "balance/foundation/base/types.hpp"
#include "balance/foundation/numerics/chebyshev_series.hpp"
#include "balance/mechanics/trajectory/drive_sample.hpp"
#include "balance/mechanics/trajectory/optimised_law.hpp"
#include "balance/mechanics/trajectory/trajectory.hpp"

#include <memory>
#include <vector>

namespace balance::trajectory {

/// A function added to one component: of time as a fraction of the duration, or of the path parameter.
struct ComponentOffset {
  Eigen::Index component = 0;
  numerics::PiecewiseChebyshevSeries
      series;  ///< value, first and second derivative on [0, 1]; the first two are continuous
  bool over_time = true;
};

/// A law on a path. Immutable; evaluation does not allocate once the sample has its size.
class PrescribedMotion {
 public:
  struct Request {
    MotionLaw law;
    Path path;
    double duration = 1;  ///< [s]; for a table, replaced by its own
    /// Both have the same k. Ignored for tables (k may come from the table alone). A circle uses `to` only for the
    /// components that are not on the circle, and not at all if `to.value` is empty.
    DriveValue from, to;
    std::vector<DriveValue> via;  ///< WaypointPath: the points in the drive's components, in order
    /// Number of leading components that are coordinates of a point: arcs and circles need 2 or 3, chord lengths use
    /// them.
    int position_components = 0;
    bool has_rotation = false;  ///< the rotation is prescribed too: the shortest rotation on each leg
    std::vector<ComponentOffset> component_offsets;  ///< not with tables
    /// Times at which something other than the motion jumps, e.g. a payload [s]. jump_times() includes those strictly
    /// inside.
    std::vector<double> switch_times;
    bool has_real_time = true;  ///< false: the time only counts the way, and constraints on speeds are kept at zero
  };

  /// @throws std::invalid_argument if sizes differ, numbers are not finite, the law is invalid, the three points of an
  ///        arc are collinear, a circle is requested for components that are not a point, times do not increase, or the
  ///        orientations of a spline are too far from each other. The message is suitable for users.
  explicit PrescribedMotion(const Request& request);
  ~PrescribedMotion();
  PrescribedMotion(PrescribedMotion&&) noexcept;
  PrescribedMotion& operator=(PrescribedMotion&&) noexcept;

  /// @param time in [0, duration]; for a table, counted from its first time
  /// @param side one-sided limit to take where the acceleration jumps; at the ends, always the inner one. Times within
  ///        1e-12 of the duration from a jump count as the jump.
  /// @throws std::invalid_argument if time is outside by more than round-off (1e-9 of the duration)
  void at(double time, Side side, DriveSample& sample) const;

  /// Progress along the whole path, 0 to 1, with its first [1/s] and second [1/s^2] derivative. For a table, progress
  /// is time.
  MotionLawValue path_progress(double time, Side side) const;

  /// The longest step [s] from a time that does not skip features of the path: a fraction of its leg, and at most one
  /// knot interval of a spline.
  double max_step(double time) const;

  double duration() const;
  /// Number k of scalar components.
  int component_count() const;
  /// Times strictly inside (0, duration) at which an acceleration (for uniform legs: a velocity) jumps or the request
  /// has a switch time, increasing.
  const std::vector<double>& jump_times() const;
  /// Times strictly inside (0, duration) at which one leg ends and the next begins, increasing. Not for optimised laws.
  std::vector<double> segment_end_times() const;
  /// Times strictly inside at which a third derivative jumps, because a spline or an offset has a knot there,
  /// increasing. Only for a uniform law.
  std::vector<double> knot_times() const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

// Motion laws in the phase plane.

/// Fills the time, path parameter and path rate of a phase plane.
void sample_phase_plane(const PrescribedMotion& motion, PhasePlane& plane);

}  // namespace balance::trajectory
