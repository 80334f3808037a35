#pragma once
/// A law of motion put on a stretch of time.

#include "balance/foundation/numerics/cubic_spline.hpp"
#include "balance/mechanics/trajectory/motion_law.hpp"
#include "balance/mechanics/trajectory/prescribed_motion.hpp"

#include <algorithm>
#include <cmath>
#include <variant>
#include <vector>

namespace balance {

/// Immutable; says how far along its curve a leg is at a time.
class TimeScaling {
 public:
  /// @param start when the leg begins [s]
  /// @param duration how long it takes, positive [s]
  /// @param tolerance times nearer than this to a jump of the law count as the jump itself [s]
  TimeScaling(const MotionLaw& law, double start, double duration, double tolerance)
      : law_(law),
        jumps_(balance::find_acceleration_jumps(law)),
        start_(start),
        duration_(duration),
        rate_(1 / duration),
        tolerance_(tolerance / duration) {}

  /// s, ds/dt [1/s] and d²s/dt² [1/s^2]; before the start and after the end the values there.
  MotionLawValue at(double time, Side side) const {
    double tau = std::clamp((time - start_) / duration_, 0.0, 1.0);
    // Grid times such as k T / (N − 1) miss a jump at T / 2 by round-off; without this the side would not be honoured
    // there.
    for (const double jump : jumps_) {
      if (std::abs(tau - jump) <= tolerance_) tau = jump;
    }
    const MotionLawValue value = evaluate(law_, tau, side);
    return {value.s, value.ds * rate_, value.dds * rate_ * rate_};
  }

  double start() const { return start_; }
  double duration() const { return duration_; }

  /// Times inside the leg at which the law's second derivative jumps, increasing [s].
  std::vector<double> jumps() const {
    std::vector<double> times = jumps_;
    for (double& time : times) time = start_ + time * duration_;
    return times;
  }

 private:
  MotionLaw law_;
  std::vector<double> jumps_;  ///< as parts of the duration
  double start_, duration_;
  double rate_;       ///< of τ [1/s]
  double tolerance_;  ///< as a part of the duration
};

// Curves in the drive's components. Each is a function of one parameter s in [0, 1] and fills a sample's value, rate
// and acceleration from s and its time derivatives. Immutable; filling allocates nothing.

/// From `start` to `start + delta`.
struct StraightCurve {
  VectorX start, delta;  ///< k entries each

  void fill(const MotionLawValue& progress, DriveSample& sample) const;
};

/// The leading components go round a circle, the others straight.
struct CircularCurve {
  StraightCurve straight_part;  ///< all components; what it says of the leading ones is replaced
  int dimensions = 2;           ///< how many components lead, 2 or 3
  Vector3 centre, u, v;  ///< position(φ) = centre + cos φ u + sin φ v, where u and v have the length of the radius [m]
  double sweep = 0;      ///< φ at s = 1 [rad]

  void fill(const MotionLawValue& progress, DriveSample& sample) const;
};

/// Through points, twice continuously differentiable.
struct SplineCurve {
  CubicSpline spline;

  void fill(const MotionLawValue& progress, DriveSample& sample) const;
};

using Curve = std::variant<StraightCurve, CircularCurve, SplineCurve>;

/// Round the axis through `centre` along `normal`, starting at `start.value`.
/// @param dimensions how many leading components are a point's coordinates
/// @throws std::invalid_argument if they are fewer than two, the circle leaves the plane of a planar point, it has no
///         radius or no angle
CircularCurve make_circle(const StraightCurve& rest, int dimensions, const CirclePath& path);

/// From the start of `rest` through `path.via` to its end.
/// @throws std::invalid_argument if there are fewer than two leading components or the three points lie on one line
CircularCurve make_circular_arc(const StraightCurve& rest, int dimensions, const ArcPath& path);

// Rotations along one parameter s in [0, 1]. Each fills a sample's rotation, angular velocity and angular
// acceleration (world axes) from s and its time derivatives. Immutable; filling allocates nothing.

/// No rotation is prescribed.
struct NoRotation {
  void fill(const MotionLawValue& progress, DriveSample& sample) const;
};

/// About one world axis, by `angle` at s = 1.
struct FixedAxisRotation {
  Matrix3 start;
  Vector3 axis;      ///< unit, world axes
  double angle = 0;  ///< [rad]

  void fill(const MotionLawValue& progress, DriveSample& sample) const;
};

/// R(s) = exp(φ(s)) · reference, where the rotation vector φ is a C² spline: so R is C², and where all orientations
/// share one axis it is the spline of the angle.
struct SplineRotation {
  Matrix3 reference;
  CubicSpline rotation_vector;  ///< three components [rad], world axes

  void fill(const MotionLawValue& progress, DriveSample& sample) const;
};

using RotationCurve = std::variant<NoRotation, FixedAxisRotation, SplineRotation>;

/// The shortest rotation. At exactly half a turn, where there are two, it takes either.
FixedAxisRotation find_shortest_rotation(const Matrix3& from, const Matrix3& to);

/// Through all rotations, each to the next by less than half a turn.
/// @param knots increasing, one per rotation
/// @throws std::invalid_argument if they wander too far apart for a rotation vector to follow. The message is fit for
///        a user.
SplineRotation interpolate_rotations(const std::vector<double>& knots, const std::vector<Matrix3>& rotations);

/// Through rotation vectors (rows of three), natural reading: a row that another rotation vector of the same rotation
/// brings nearer to the row before is replaced by that one, so that a jump from +π to −π does no harm.
SplineRotation interpolate_rotation_vectors(const std::vector<double>& knots, Samples vectors);

// What a schedule is made of: legs, each a clock, a curve and a rotation.

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
