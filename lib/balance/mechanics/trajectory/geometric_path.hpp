#pragma once
/// Legs of a prescribed motion: time scalings, curves and rotations.

#include "balance/foundation/numerics/cubic_spline.hpp"
#include "balance/mechanics/trajectory/motion_law.hpp"
#include "balance/mechanics/trajectory/prescribed_motion.hpp"

#include <algorithm>
#include <cmath>
#include <variant>
#include <vector>

namespace balance::trajectory {

/// Progress of a leg along its curve as a function of time. Immutable.
class TimeScaling {
 public:
  /// @param start time at which the leg begins [s]
  /// @param duration of the leg, positive [s]
  /// @param tolerance times closer than this to a jump of the law count as the jump [s]
  TimeScaling(const MotionLaw& law, double start, double duration, double tolerance)
      : law_(law),
        jumps_(trajectory::find_acceleration_jumps(law)),
        start_(start),
        duration_(duration),
        rate_(1 / duration),
        tolerance_(tolerance / duration) {}

  /// s, ds/dt [1/s] and d²s/dt² [1/s^2]. Times outside the leg are clamped to it.
  MotionLawValue at(double time, Side side) const {
    double tau = std::clamp((time - start_) / duration_, 0.0, 1.0);
    // Grid times such as k T / (N − 1) miss a jump at T / 2 by round-off, and `side` would then have no effect there.
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
  std::vector<double> jumps_;  ///< as fractions of the duration
  double start_, duration_;
  double rate_;       ///< of τ [1/s]
  double tolerance_;  ///< as a fraction of the duration
};

// Curves in the drive's components. Each is a function of one parameter s in [0, 1] and fills a sample's value, rate
// and acceleration from s and its time derivatives. Immutable; filling allocates nothing.

/// From `start` to `start + delta`.
struct StraightCurve {
  VectorX start, delta;  ///< k entries each

  void fill(const MotionLawValue& progress, DriveSample& sample) const;
};

/// The leading components move on a circle, the others on a straight line.
struct CircularCurve {
  StraightCurve straight_part;  ///< all components; the leading ones are overridden
  int dimensions = 2;           ///< number of leading components, 2 or 3
  Vector3 centre, u, v;  ///< position(φ) = centre + cos φ u + sin φ v, where u and v have the length of the radius [m]
  double sweep = 0;      ///< φ at s = 1 [rad]

  void fill(const MotionLawValue& progress, DriveSample& sample) const;
};

/// C² spline through points.
struct SplineCurve {
  numerics::CubicSpline spline;

  void fill(const MotionLawValue& progress, DriveSample& sample) const;
};

using Curve = std::variant<StraightCurve, CircularCurve, SplineCurve>;

/// Circle about the axis through `path.centre` along `path.normal`, starting at `straight.start`.
/// @param dimensions number of leading components that are coordinates of a point
/// @throws std::invalid_argument if there are fewer than two, the circle leaves the plane of a planar point, or its
///        radius or angle is zero
CircularCurve make_circle(const StraightCurve& straight, int dimensions, const CirclePath& path);

/// Arc from the start of `straight` through `path.via` to its end.
/// @throws std::invalid_argument if there are fewer than two leading components or the three points are collinear
CircularCurve make_circular_arc(const StraightCurve& straight, int dimensions, const ArcPath& path);

// Rotations along one parameter s in [0, 1]. Each fills a sample's rotation, angular velocity and angular
// acceleration (world axes) from s and its time derivatives. Immutable; filling allocates nothing.

/// No rotation is prescribed.
struct NoRotation {
  void fill(const MotionLawValue& progress, DriveSample& sample) const;
};

/// Rotation about a fixed world axis, by `angle` at s = 1.
struct FixedAxisRotation {
  Matrix3 start;
  Vector3 axis;      ///< unit, world axes
  double angle = 0;  ///< [rad]

  void fill(const MotionLawValue& progress, DriveSample& sample) const;
};

/// R(s) = exp(φ(s)) · reference, where the rotation vector φ is a C² spline. Thus R is C²; if all orientations share
/// one axis, it is the spline of the angle.
struct SplineRotation {
  Matrix3 reference;
  numerics::CubicSpline rotation_vector;  ///< three components [rad], world axes

  void fill(const MotionLawValue& progress, DriveSample& sample) const;
};

using RotationCurve = std::variant<NoRotation, FixedAxisRotation, SplineRotation>;

/// The shortest rotation; at exactly half a turn, either of the two.
FixedAxisRotation find_shortest_rotation(const Matrix3& from, const Matrix3& to);

/// Spline through all rotations that turns less than half a turn from each to the next.
/// @param knots increasing, one per rotation
/// @throws std::invalid_argument if they are too far from each other for a spline of rotation vectors. The message is
///        suitable for users.
SplineRotation interpolate_rotations(const std::vector<double>& knots, const std::vector<Matrix3>& rotations);

/// Spline through rotation vectors (rows of three). Each row is replaced by the equivalent rotation vector nearest to
/// the row before, so that a jump from +π to −π does no harm.
SplineRotation interpolate_rotation_vectors(const std::vector<double>& knots, Samples vectors);

// Legs of a prescribed motion, each with a time scaling, a curve and a rotation.

/// Times closer than this fraction of the whole duration coincide: some thousand ulp, far below any sampling interval.
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

/// @throws std::invalid_argument as the constructor of PrescribedMotion
SegmentedPath make_segmented_path(const PrescribedMotion::Request& request);

/// Fractions of the duration at which the waypoints are passed, in order, including the start (0) and the end (1).
/// @param points start, waypoints, end
/// @param fractions of the waypoints; empty: by chord length between the points
std::vector<double> compute_waypoint_fractions(const std::vector<DriveValue>& points,
                                               const std::vector<double>& fractions, int position_components,
                                               bool has_rotation);

}  // namespace balance::trajectory
