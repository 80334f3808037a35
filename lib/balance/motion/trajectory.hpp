#pragma once
/// A trajectory as the spec states it: which quantities are prescribed, from where to where, along which path, by
/// which law. Like a mechanism's (model/mechanism.hpp) its numbers are of any scalar.

#include "balance/model/mechanism.hpp"
#include "balance/motion/law.hpp"

#include <array>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace balance {

/// What is prescribed: joint coordinates, the tool's pose, or the centre of mass of all moving bodies.
enum class DriveKind { joints, tool, com };

/// Values that pin a pose of the mechanism. Whatever is not given stays unset.
template <class T>
struct PoseTargetOf {
  std::vector<CoordinateValueOf<T>> joints;  ///< empty if not given
  std::optional<Vector3Of<T>> tool;          ///< world position of the tool point [m] (planar: z = 0)
  std::optional<T> angle;                    ///< planar: angle of the tool body's x axis in the world [rad]
  std::optional<Matrix3Of<T>> orientation;   ///< spatial: rotation of the tool's body in the world
  std::optional<Vector3Of<T>> com;           ///< world position of the centre of mass [m]
};

struct LinePath {};

/// Through the starting point, about `centre`, by the signed `angle` (2π: a full circle). The end point is where the arc ends.
template <class T>
struct CirclePathOf {
  Vector3Of<T> centre = Vector3Of<T>::Zero();
  Vector3Of<T> normal = Vector3Of<T>::UnitZ();  ///< unit vector
  T angle = 0;                                  ///< [rad]
};

/// The circular arc from the start through `via` to the end.
template <class T>
struct ArcPathOf {
  Vector3Of<T> via = Vector3Of<T>::Zero();
};

/// Points between `from` and `to`, given in the drive's own quantities.
template <class T>
struct WaypointPathOf {
  std::vector<PoseTargetOf<T>> points;
  bool spline =
      false;  ///< false: a stop at every point, each leg by the law; true: one C² cubic spline, law on its parameter
  std::vector<T>
      fractions;  ///< when each point is passed, as increasing parts of the duration in (0, 1); empty: by chord length
};

/// Prescribed values over time, joined by a C² cubic spline (not-a-knot). The law is not used.
template <class T>
struct TablePathOf {
  std::vector<T> time;  ///< increasing, at least 4 [s]; the motion starts at the first and ends at the last
  std::vector<std::vector<T>>
      values;  ///< one row per time, one entry per driven component in the drive's order (planar angle included; a spatial orientation as rotation vector)
};

template <class T>
using PathOf = std::variant<LinePath, CirclePathOf<T>, ArcPathOf<T>, WaypointPathOf<T>, TablePathOf<T>>;

/// One scalar of the tool's pose or of the CoM: x, y, z, then the angle (planar: rz) or rotation about the world axes.
enum class Component { x, y, z, rx, ry, rz };

/// What a law that is searched for must keep: a quantity's magnitude, at every moment, up to a bound.
template <class T>
struct MotionLimitOf {
  std::string quantity;  ///< "torque" (every actuator's), "torque[A1]", "shaking_force", "shaking_force[x]", …
  T bound = 0;           ///< positive [SI]
};

template <class T>
struct TrajectoryOf {
  std::string name;
  LawOf<T> law;
  std::vector<MotionLimitOf<T>> limits;  ///< law fastest: at least one; gentlest: perhaps
  std::string gentlest_of;               ///< law gentlest: whose peak is to be least
  T start_speed = 0;  ///< law fastest or gentlest: of the driven point along its path [m/s]; joints: norm of their
  T end_speed = 0;    ///< … rates
  DriveKind drive = DriveKind::tool;
  /// Which scalars are prescribed; empty: as many as the degrees of freedom ask for, positions first (drive tool, com).
  std::vector<Component> components;
  /// Drive com: coordinates that go from their value at the start pose to their value at the end pose by the same law.
  /// Empty: the tool's angle or orientation if there is a tool, else the last actuated coordinates, as many as needed.
  std::vector<int> remaining;
  PathOf<T> path;
  PoseTargetOf<T> from,
      to;          ///< poses, in any quantity: drive com takes the CoM from where `from` puts it to where `to` puts it
  T duration = 1;  ///< [s]; law fastest: what the search finds
  long samples = 1001;                        ///< uniform grid, both ends included; at least 2
  Vector3Of<T> about = Vector3Of<T>::Zero();  ///< world point that moments are about [m]
};

using PoseTarget = PoseTargetOf<double>;
using CirclePath = CirclePathOf<double>;
using ArcPath = ArcPathOf<double>;
using WaypointPath = WaypointPathOf<double>;
using TablePath = TablePathOf<double>;
using Path = PathOf<double>;
using MotionLimit = MotionLimitOf<double>;
using Trajectory = TrajectoryOf<double>;

}  // namespace balance
