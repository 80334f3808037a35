#pragma once
/// A trajectory as the spec states it: which quantities are prescribed, from where to where, along which path, by
/// which law. Like a mechanism's (mechanics/model/mechanism.hpp) its numbers are of any scalar.

#include "balance/foundation/numerics/chebyshev_series.hpp"
#include "balance/mechanics/model/mechanism.hpp"
#include "balance/mechanics/trajectory/motion_law.hpp"
#include "balance/mechanics/trajectory/motion_outcome.hpp"

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace balance {

// A path with a width: how it is left is found for the mechanism.

/// The driven point may leave its path, which is a line, a circle or an arc, at right angles to it; where joints are driven their
/// coordinates may, as one point. Both ends stay. Derivation: docs/motion.md.
template <class T>
struct CorridorOf {
  T width = 0;          ///< how far at most, to every side [m or rad], positive
  int inner_knots = 7;  ///< inner ones of the cubic splines that the offset is made of, evenly spaced
  int starts = 3;       ///< of the search
  std::vector<double>
      control_points;  ///< of the splines, knots + 2 for each direction [m or rad]; empty: not found yet
};

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

/// What a law that is searched for must keep at every moment: a quantity's magnitude up to a bound, or a scalar between two.
template <class T>
struct MotionLimitOf {
  std::string quantity;  ///< "torque" (every actuator's), "torque[A1]", "shaking_force", "shaking_force[x]", …
  T upper_bound = 0;     ///< [SI]; positive where there is no `least`
  std::optional<T> lower_bound;  ///< of a scalar, less than `bound` [SI]; nothing: −bound
};

/// A cubic spline is added to the straight way of a quantity, zero with its rate at both ends.
template <class T>
struct SplineTaskOf {
  std::vector<T> coefficients;   ///< of its cubic B-splines on evenly spaced knots, at least one [rad or m]
  bool has_middle_jump = false;  ///< its second derivative may jump in the middle: then an even number of them
  bool over_time = true;         ///< a function of the time as part of the duration; false: of the way
};

/// A quantity goes as a component of the angular momentum about the trajectory's `about` asks for; its end value follows.
template <class T>
struct MomentumTaskOf {
  int axis = 2;  ///< x, y, z of the world; planar: z
  std::vector<T>
      time;  ///< of the stated values, increasing, joined by a C² cubic spline [s]; empty: there is one value
  std::vector<T> value;               ///< [N m s]; empty: zero
  PiecewiseChebyshevSeries solution;  ///< less the start, with two derivatives; empty: not found yet
  bool over_time = false;  ///< the course is a function of the time as part of the duration; false: of the way
};

/// What a remaining quantity does besides going straight from its start to its end.
template <class T>
struct SecondaryTaskOf {
  CoordinateId coordinate = -1;  ///< −1: the planar tool's angle
  std::variant<SplineTaskOf<T>, MomentumTaskOf<T>> kind;
};

template <class T>
struct TrajectoryOf {
  std::string name;
  MotionLawOf<T> law;
  /// Law fastest: at least one; gentlest: perhaps; others go as they go, and their limits are only told
  /// (mechanics/trajectory/optimised_law.hpp).
  std::vector<MotionLimitOf<T>> limits;
  std::string min_peak_quantity;  ///< law gentlest, or in a corridor: whose peak is to be least
  T start_speed = 0;  ///< law fastest or gentlest: of the driven point along its path [m/s]; joints: norm of their
  T end_speed = 0;    ///< … rates
  DriveKind drive = DriveKind::tool;
  /// Which scalars are prescribed; empty: as many as the degrees of freedom ask for, positions first (drive tool, com).
  std::vector<Component> components;
  /// Drive com: coordinates that go from their value at the start pose to their value at the end pose by the same law.
  /// Empty: the tool's angle or orientation if there is a tool, else the last actuated coordinates, as many as needed.
  std::vector<CoordinateId> remaining_coordinates;
  bool remaining_angle = false;                     ///< the planar tool's angle is among them, before the others
  std::vector<SecondaryTaskOf<T>> secondary_tasks;  ///< of remaining quantities, each once
  PathOf<T> path;
  PoseTargetOf<T> from,
      to;          ///< poses, in any quantity: drive com takes the CoM from where `from` puts it to where `to` puts it
  T duration = 1;  ///< [s]; law fastest: what the search finds
  long samples = 1001;                        ///< uniform grid, both ends included; at least 2
  Vector3Of<T> about = Vector3Of<T>::Zero();  ///< world point that moments are about [m]
  std::optional<CorridorOf<T>> corridor;      ///< round the path
};

/// The mechanism decides how this goes: its law, its way or a course is found for it, by motion/time_optimal.
template <class T>
bool is_mechanism_dependent(const TrajectoryOf<T>& trajectory) {
  return is_mechanism_dependent(trajectory.law.kind) || trajectory.corridor.has_value() ||
         std::any_of(trajectory.secondary_tasks.begin(), trajectory.secondary_tasks.end(),
                     [](const auto& course) { return std::holds_alternative<MomentumTaskOf<T>>(course.kind); });
}

using PoseTarget = PoseTargetOf<double>;
using CirclePath = CirclePathOf<double>;
using ArcPath = ArcPathOf<double>;
using WaypointPath = WaypointPathOf<double>;
using TablePath = TablePathOf<double>;
using Path = PathOf<double>;
using MotionLimit = MotionLimitOf<double>;
using SplineTask = SplineTaskOf<double>;
using MomentumTask = MomentumTaskOf<double>;
using SecondaryTask = SecondaryTaskOf<double>;
using Corridor = CorridorOf<double>;
using Trajectory = TrajectoryOf<double>;

/// How long a motion may last and how often it may be sampled, wherever that is stated: beyond, a misprint is likelier than a wish.
inline constexpr double min_duration = 1e-9, max_duration = 1e9;  ///< [s]
inline constexpr long min_samples = 2, max_samples = 100'000'000;

/// "a duration from 1e-09 s to 1e+09 s"
std::string format_duration_range();

inline bool is_valid_duration(double duration) { return duration >= min_duration && duration <= max_duration; }
inline bool is_valid_sample_count(long samples) { return samples >= min_samples && samples <= max_samples; }

/// @throws std::invalid_argument if the trajectory is longer, shorter, or sampled more or less often than any may be
void check_timing(const Trajectory& trajectory);

/// @param duration [s] @throws std::invalid_argument if it is none, or something else says how long the trajectory takes
void change_duration(Trajectory& trajectory, double duration);

/// @throws std::invalid_argument if there cannot be so many
void change_samples(Trajectory& trajectory, long samples);

/// What the spec language calls laws, drives and the ways a motion ends.
const char* name_of(MotionLawKind kind);  ///< "cycloidal", "bang-bang", …
/// Of what leads a trajectory through time: its law, or "table".
const char* law_name(const Trajectory& trajectory);
const char* name_of(DriveKind kind);       ///< "joints", "tool", "com"
const char* name_of(MotionStatus status);  ///< "done", "drive-singularity", …

}  // namespace balance
