#pragma once
/// A trajectory as specified: which quantities are prescribed, from where to where, along which path and by which law.
/// Its scalar type is a template parameter, like that of a mechanism (mechanics/model/mechanism.hpp).

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

namespace balance::trajectory {

// A path with a width; the offset from the path is found for the mechanism.

/// The driven point may leave its path (a line, circle or arc) perpendicular to it. For driven joints, the point is
/// that of their coordinates. Both ends are fixed. Derivation: docs/motion.md.
template <class T>
struct CorridorOf {
  T width = 0;          ///< maximum offset in every direction [m or rad], positive
  int inner_knots = 7;  ///< number of inner knots of the offset's cubic splines, evenly spaced
  int starts = 3;       ///< number of starts of the search
  std::vector<double>
      control_points;  ///< of the splines, knots + 2 for each direction [m or rad]; empty: not found yet
};

/// What is prescribed: joint coordinates, the tool's pose, or the centre of mass of all moving bodies.
enum class DriveKind { joints, tool, com };

/// Values that determine a pose of the mechanism. Values that are not given stay unset.
template <class T>
struct PoseTargetOf {
  std::vector<model::CoordinateValueOf<T>> joints;  ///< empty if not given
  std::optional<Vector3Of<T>> tool;                 ///< world position of the tool point [m] (planar: z = 0)
  std::optional<T> angle;                           ///< planar: angle of the tool body's x axis in the world [rad]
  std::optional<Matrix3Of<T>> orientation;          ///< spatial: rotation of the tool's body in the world
  std::optional<Vector3Of<T>> com;                  ///< world position of the centre of mass [m]
};

struct LinePath {};

/// Circle through the start, about `centre`, by the signed `angle` (2π: a full circle). The end follows.
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

/// Points between `from` and `to`, in the drive's own quantities.
template <class T>
struct WaypointPathOf {
  std::vector<PoseTargetOf<T>> points;
  bool spline =
      false;  ///< false: stop at every point, the law on each leg; true: one C² cubic spline, the law on its parameter
  std::vector<T>
      fractions;  ///< when each point is passed: increasing fractions of the duration in (0, 1); empty: by chord length
};

/// Prescribed values over time, interpolated by a C² cubic spline (not-a-knot). The law is not used.
template <class T>
struct TablePathOf {
  std::vector<T> time;  ///< increasing, at least 4 [s]; the motion starts at the first and ends at the last
  std::vector<std::vector<T>>
      values;  ///< one row per time, one entry per driven component in the drive's order (planar angle included; a
               ///< spatial orientation as rotation vector)
};

template <class T>
using PathOf = std::variant<LinePath, CirclePathOf<T>, ArcPathOf<T>, WaypointPathOf<T>, TablePathOf<T>>;

/// One scalar of the pose of the tool or of the CoM: x, y, z, then the angle (planar: rz) or rotation about the world
/// axes.
enum class Component { x, y, z, rx, ry, rz };

/// Limit that an optimised law satisfies at all times: an upper bound on a quantity's magnitude, or a range of a
/// scalar.
template <class T>
struct MotionLimitOf {
  std::string quantity;          ///< "torque" (all actuators), "torque[A1]", "shaking_force", "shaking_force[x]", …
  T upper_bound = 0;             ///< [SI]; positive if there is no lower bound
  std::optional<T> lower_bound;  ///< of a scalar, less than `upper_bound` [SI]; none: −upper_bound
};

/// A cubic spline added to the straight motion of a quantity; zero value and rate at both ends.
template <class T>
struct SplineTaskOf {
  std::vector<T> coefficients;   ///< of the cubic B-splines on evenly spaced knots, at least one [rad or m]
  bool has_middle_jump = false;  ///< the second derivative may jump in the middle; needs an even number of coefficients
  bool over_time = true;         ///< function of time as a fraction of the duration; false: of the path parameter
};

/// The quantity moves as required by a component of the angular momentum about the trajectory's `about`; its end value
/// follows.
template <class T>
struct MomentumTaskOf {
  int axis = 2;  ///< x, y, z of the world; planar: z
  std::vector<T>
      time;  ///< times of the values, increasing; interpolation by a C² cubic spline [s]; empty: a single value
  std::vector<T> value;                         ///< [N m s]; empty: zero
  numerics::PiecewiseChebyshevSeries solution;  ///< relative to the start, with two derivatives; empty: not found yet
  bool over_time = false;  ///< function of time as a fraction of the duration; false: of the path parameter
};

/// Motion of a remaining quantity in addition to the straight motion from its start to its end.
template <class T>
struct SecondaryTaskOf {
  CoordinateId coordinate = -1;  ///< −1: angle of the planar tool
  std::variant<SplineTaskOf<T>, MomentumTaskOf<T>> kind;
};

// Counterweights that follow the payload during the motion.

/// One move of a counterweight along its body, from rest to rest.
template <class T>
struct CounterweightMoveOf {
  Vector3Of<T> to = Vector3Of<T>::Zero();  ///< place at the end, in the body's axes [m]
  double start = 0;                        ///< [s]
  double duration = 1;                     ///< [s]
  MotionLawOf<T> law;
};

/// A counterweight that a motor of its own moves along its body (mechanics/trajectory/adaptation.hpp).
template <class T>
struct AdaptationOf {
  int attachment = 0;                         ///< into Mechanism::attachments
  std::vector<CounterweightMoveOf<T>> moves;  ///< in order of time, one after the other; all places are on one line
};

/// A move of a coordinate by a law of its own, from rest to rest.
struct CoordinateMove {
  double start = 0, duration = 1;  ///< [s]
  double distance = 0;             ///< signed [rad or m]
  MotionLaw law;
};

/// A coordinate whose motion is independent of the path, whatever is driven. At rest between its moves, or as its
/// equation of motion says.
struct CoordinateCourse {
  CoordinateId coordinate = 0;
  std::vector<CoordinateMove> moves;  ///< in order of time
  /// Of a free coordinate, instead of moves: function of the fraction of the duration, relative to the start, with two
  /// derivatives.
  numerics::PiecewiseChebyshevSeries solution = {};

  bool is_free() const { return !solution.panels().empty(); }
};

/// Both ends of all moves, in the order of the courses [s].
std::vector<double> list_move_times(const std::vector<CoordinateCourse>& courses);

// Partly driven mechanisms.

/// How free coordinates start.
enum class FreeStart {
  given,        ///< values and rates as stated
  equilibrium,  ///< at rest where, with the driven coordinates at rest at the start, nothing accelerates them
  periodic      ///< so that after the duration they are where they were, with the same rates
};

/// Some coordinates follow the trajectory; the others move by the mechanism's dynamics, without an effort of their own
/// (motion/simulation/free_motion.hpp). All of them start at TrajectoryOf::from; for other starts than `given`, the
/// search for the free ones begins there.
template <class T>
struct FreeMotionOf {
  std::vector<CoordinateId> free;
  std::vector<CoordinateId> held;  ///< keep their values at the start
  FreeStart start = FreeStart::given;
  std::vector<model::CoordinateValueOf<T>> rate;  ///< of free coordinates at the start [rad/s or m/s]; none: zero
};

template <class T>
struct TrajectoryOf {
  std::string name;
  MotionLawOf<T> law;
  /// Law fastest: at least one. Law gentlest: optional. For other laws, limits are only reported
  /// (mechanics/trajectory/optimised_law.hpp).
  std::vector<MotionLimitOf<T>> limits;
  std::string min_peak_quantity;  ///< law gentlest, or in a corridor: quantity whose peak is minimised
  T start_speed = 0;  ///< law fastest or gentlest: speed of the driven point along its path [m/s], for joints the norm
  T end_speed = 0;    ///< … of their rates
  DriveKind drive = DriveKind::tool;
  /// Prescribed scalars; empty: as many as there are degrees of freedom, positions first (drives tool and com).
  std::vector<Component> components;
  /// Drive com: coordinates that move from their values at the start pose to those at the end pose by the same law.
  /// Empty: the tool's angle or orientation if there is a tool, else the last actuated coordinates, as many as needed.
  std::vector<CoordinateId> remaining_coordinates;
  bool remaining_angle = false;                     ///< the planar tool's angle is one of them, before the coordinates
  std::vector<SecondaryTaskOf<T>> secondary_tasks;  ///< for remaining quantities, at most one each
  PathOf<T> path;
  PoseTargetOf<T> from,
      to;               ///< poses, in any quantity; drive com moves the CoM from its position at `from` to that at `to`
  T duration = 1;       ///< [s]; law fastest: result of the search
  long samples = 1001;  ///< uniform grid, both ends included; at least 2
  Vector3Of<T> about = Vector3Of<T>::Zero();  ///< reference point of moments in the world [m]
  std::optional<CorridorOf<T>> corridor;      ///< around the path
  std::vector<AdaptationOf<T>> adaptations;   ///< at most one per counterweight
  /// Not part of the path or of the drive's other quantities; the start values are in `from`.
  std::vector<CoordinateCourse> courses;
  std::optional<FreeMotionOf<T>> free_motion;  ///< with drive joints
};

/// Whether the motion depends on the mechanism: motion/time_optimal then finds its law, corridor offset or momentum
/// task.
template <class T>
bool is_mechanism_dependent(const TrajectoryOf<T>& trajectory) {
  return is_mechanism_dependent(trajectory.law.kind) || trajectory.corridor.has_value() ||
         std::any_of(trajectory.secondary_tasks.begin(), trajectory.secondary_tasks.end(),
                     [](const auto& task) { return std::holds_alternative<MomentumTaskOf<T>>(task.kind); });
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
using CounterweightMove = CounterweightMoveOf<double>;
using Adaptation = AdaptationOf<double>;
using FreeMotion = FreeMotionOf<double>;
using Corridor = CorridorOf<double>;
using Trajectory = TrajectoryOf<double>;

/// Duration of the trajectory [s]: its own, or its table's.
double find_trajectory_duration(const Trajectory& trajectory);

/// Range of durations and sample counts, wherever they are specified. Values outside are more likely misprints than
/// intended.
inline constexpr double min_duration = 1e-9, max_duration = 1e9;  ///< [s]
inline constexpr long min_samples = 2, max_samples = 100'000'000;

/// "a duration from 1e-09 s to 1e+09 s"
std::string format_duration_range();

inline bool is_valid_duration(double duration) { return duration >= min_duration && duration <= max_duration; }
inline bool is_valid_sample_count(long samples) { return samples >= min_samples && samples <= max_samples; }

/// @throws std::invalid_argument if the duration or the number of samples is out of range
void check_timing(const Trajectory& trajectory);

/// @param duration [s]
/// @throws std::invalid_argument if it is out of range, or if the law or a table determines the duration
void change_duration(Trajectory& trajectory, double duration);

/// @throws std::invalid_argument if the number is out of range
void change_samples(Trajectory& trajectory, long samples);

/// Names of laws, drives and motion outcomes in the spec language.
const char* name_of(MotionLawKind kind);  ///< "cycloidal", "bang-bang", …
/// Name of the trajectory's law, or "table".
const char* law_name(const Trajectory& trajectory);
const char* name_of(DriveKind kind);       ///< "joints", "tool", "com"
const char* name_of(MotionStatus status);  ///< "done", "drive-singularity", …

}  // namespace balance::trajectory

namespace balance {

using trajectory::DriveKind;
using trajectory::Trajectory;
using trajectory::TrajectoryOf;

}  // namespace balance
