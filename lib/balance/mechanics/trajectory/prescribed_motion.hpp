#pragma once
/// The prescribed quantities as functions of time: a path in the drive's components, run through by a law.

#include "balance/foundation/base/types.hpp"
#include "balance/foundation/numerics/chebyshev_series.hpp"
#include "balance/mechanics/trajectory/drive_sample.hpp"
#include "balance/mechanics/trajectory/optimised_law.hpp"
#include "balance/mechanics/trajectory/trajectory.hpp"

#include <memory>
#include <vector>

namespace balance {

/// A function added to one component: over the time as part of the duration, or over the way.
struct ComponentOffset {
  Eigen::Index component = 0;
  PiecewiseChebyshevSeries series;  ///< value, first and second derivative, over 0 to 1; the first two without jumps
  bool over_time = true;
};

/// A law on a path. Immutable; evaluation allocates nothing once the sample has its size.
class PrescribedMotion {
 public:
  struct Request {
    MotionLaw law;
    Path path;
    double duration = 1;  ///< [s]; replaced by a table's own
    /// Same k. Tables ignore both (k may come from the table alone). A circle takes from `to` only what does not go
    /// round, and nothing at all if `to.value` is empty.
    DriveValue from, to;
    std::vector<DriveValue> via;  ///< WaypointPath: the points in the drive's components, in order
    /// How many leading components are a point's coordinates: arcs and circles need 2 or 3, chord lengths use them.
    int position_components = 0;
    bool has_rotation = false;  ///< the rotation is prescribed too; it follows the shortest rotation, leg by leg
    std::vector<ComponentOffset> component_offsets;  ///< not with tables
    /// Times at which something besides the motion jumps, such as a mass that moves: jumps() has those strictly inside [s].
    std::vector<double> switch_times;
  };

  /// @throws std::invalid_argument if sizes differ, numbers are not finite, the law is not valid, an arc's three
  ///         points lie on one line, a circle is asked of something that is no point, times do not increase, or the
  ///         orientations of a spline wander too far apart. The message is fit for a user.
  explicit PrescribedMotion(const Request& request);
  ~PrescribedMotion();
  PrescribedMotion(PrescribedMotion&&) noexcept;
  PrescribedMotion& operator=(PrescribedMotion&&) noexcept;

  /// @param time in [0, duration] (counted from the table's first time for a table)
  /// @param side which limit to take where the acceleration jumps; at the ends the inner one is always taken. Times
  ///        nearer to a jump than 1e-12 of the duration are the jump.
  /// @throws std::invalid_argument if time is further outside than round-off explains (1e-9 of the duration)
  void at(double time, Side side, DriveSample& sample) const;

  /// How far along the whole way the motion is, 0 to 1, with its first [1/s] and second [1/s^2] derivative. Of a table the way is the
  /// time.
  MotionLawValue path_progress(double time, Side side) const;

  /// The longest step [s] from a time on that cannot leave out what the path does: a part of its leg, and no more than a
  /// spline takes from knot to knot.
  double max_step(double time) const;

  double duration() const;
  /// Number k of scalar components.
  int component_count() const;
  /// Times strictly inside (0, duration) at which an acceleration (or a velocity: uniform legs) or what the request calls a switch
  /// jumps, increasing.
  const std::vector<double>& jump_times() const;
  /// Times strictly inside (0, duration) at which one leg ends and the next begins, increasing. Not of a law that was found.
  std::vector<double> segment_end_times() const;
  /// Times strictly inside at which a third derivative jumps, because a spline or a course has a knot there, increasing. Only under a
  /// uniform law.
  std::vector<double> knot_times() const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

// A law of motion in the plane of its path's place and rate.

/// Fills the time, place and rate of a phase plane.
void sample_phase_plane(const PrescribedMotion& schedule, PhasePlane& plane);

}  // namespace balance
