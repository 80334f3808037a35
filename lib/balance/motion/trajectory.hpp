#pragma once
/// A trajectory as the spec states it: which quantities are prescribed, from where to where, along which path, by
/// which law.

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
struct PoseTarget {
  std::vector<CoordinateValue> joints;  ///< empty if not given
  std::optional<Vector3> tool;          ///< world position of the tool point [m] (planar: z = 0)
  std::optional<double> angle;          ///< planar: angle of the tool body's x axis in the world [rad]
  std::optional<Matrix3> orientation;   ///< spatial: rotation of the tool's body in the world
  std::optional<Vector3> com;           ///< world position of the centre of mass [m]
};

struct LinePath {};

/// Through the starting point, about `centre`, by the signed `angle` (2π: a full circle). The end point is where the arc ends.
struct CirclePath {
  Vector3 centre = Vector3::Zero();
  Vector3 normal = Vector3::UnitZ();  ///< unit vector
  double angle = 0;                   ///< [rad]
};

/// The circular arc from the start through `via` to the end.
struct ArcPath {
  Vector3 via = Vector3::Zero();
};

/// Points between `from` and `to`, given in the drive's own quantities.
struct WaypointPath {
  std::vector<PoseTarget> points;
  bool spline =
      false;  ///< false: a stop at every point, each leg by the law; true: one C² cubic spline, law on its parameter
  std::vector<double>
      fractions;  ///< when each point is passed, as increasing parts of the duration in (0, 1); empty: by chord length
};

/// Prescribed values over time, joined by a C² cubic spline (not-a-knot). The law is not used.
struct TablePath {
  std::vector<double> time;  ///< increasing, at least 4 [s]; the motion starts at the first and ends at the last
  std::vector<std::vector<double>>
      values;  ///< one row per time, one entry per driven component in the drive's order (planar angle included; a spatial orientation as rotation vector)
};

using Path = std::variant<LinePath, CirclePath, ArcPath, WaypointPath, TablePath>;

/// One scalar of the tool's pose or of the CoM: x, y, z, then the angle (planar: rz) or rotation about the world axes.
enum class Component { x, y, z, rx, ry, rz };

/// What a law that is searched for must keep: a quantity's magnitude, at every moment, up to a bound.
struct MotionLimit {
  std::string quantity;  ///< "torque" (every actuator's), "torque[A1]", "shaking_force", "shaking_force[x]", …
  double bound = 0;      ///< positive [SI]
};

struct Trajectory {
  std::string name;
  Law law;
  std::vector<MotionLimit> limits;  ///< law fastest: at least one; gentlest: perhaps
  std::string gentlest_of;          ///< law gentlest: whose peak is to be least
  double start_speed = 0;  ///< law fastest or gentlest: of the driven point along its path [m/s]; joints: norm of their
  double end_speed = 0;    ///< … rates
  DriveKind drive = DriveKind::tool;
  /// Which scalars are prescribed; empty: as many as the degrees of freedom ask for, positions first (drive tool, com).
  std::vector<Component> components;
  /// Drive com: coordinates that go from their value at the start pose to their value at the end pose by the same law.
  /// Empty: the tool's angle or orientation if there is a tool, else the last actuated coordinates, as many as needed.
  std::vector<int> remaining;
  Path path;
  PoseTarget from,
      to;  ///< poses, in any quantity: drive com takes the CoM from where `from` puts it to where `to` puts it
  double duration = 1;              ///< [s]; law fastest: what the search finds
  long samples = 1001;              ///< uniform grid, both ends included; at least 2
  Vector3 about = Vector3::Zero();  ///< world point that moments are about [m]
};

}  // namespace balance
