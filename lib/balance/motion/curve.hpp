#pragma once
/// Curves in the drive's components. Each is a function of one parameter s in [0, 1] and fills a sample's value, rate
/// and acceleration from s and its time derivatives. Immutable; filling allocates nothing.

#include "balance/motion/law.hpp"
#include "balance/motion/schedule.hpp"
#include "balance/motion/spline.hpp"

#include <variant>

namespace balance {

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

}  // namespace balance
