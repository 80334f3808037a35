#pragma once
/// A mechanism as its designer specified it: bodies connected by joints to each other and to the ground. Plain values
/// with indices instead of names; algorithms never modify it. SI units throughout.
///
/// Planar mechanisms use the same types: positions have z = 0, axes of rotation are z, and an inertia has only its zz
/// entry.

#include "balance/foundation/base/id.hpp"
#include "balance/foundation/base/types.hpp"
#include "balance/mechanics/model/force_table.hpp"
#include "balance/mechanics/model/variable_function.hpp"

#include <cmath>
#include <concepts>
#include <cstddef>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace balance::model {

// Indices into a mechanism's lists.

using BodyId = TypedIndex<struct BodyList>;              ///< into Mechanism::bodies
using JointId = TypedIndex<struct JointList>;            ///< into Mechanism::joints
using CoordinateId = TypedIndex<struct CoordinateList>;  ///< into Mechanism::coordinates

/// Units for messages and reports, as preferred by the designer. All numbers are stored in SI.
struct DisplayUnits {
  double length = 1;  ///< [m]
  double angle = 1;   ///< [rad]
  std::string length_name = "m", angle_name = "rad";
};

/// Coordinates of a pose are computed to this accuracy, in radians or characteristic lengths.
inline constexpr double pose_round_off = 1e-12;

/// "350 mm". @param value [m] @param round_off magnitudes up to this become 0 [m]
std::string format_length(double value, const DisplayUnits& units, double round_off = 0);
/// "120 deg". @param value [rad] @param round_off magnitudes up to this become 0 [rad]
std::string format_angle(double value, const DisplayUnits& units, double round_off = 0);
/// "(350, 0) mm". @param place components [m] @param count 2 or 3
std::string format_position(const double* position, int count, const DisplayUnits& units, double round_off = 0);

// Generalised speeds: sums of rates of joint coordinates and of components of body velocities. They need not be rates
// of coordinates.

/// factor · (rate of a coordinate, or component of a velocity). The `_body` kinds take components along the moving body
/// axes, `com_velocity` those of the velocity of the centre of mass of all moving bodies.
template <class T>
struct GeneralisedSpeedTermOf {
  enum class Kind { coordinate, velocity, velocity_body, angular_velocity, angular_velocity_body, com_velocity };
  Kind kind = Kind::coordinate;
  int index = 0;    ///< coordinate of the mechanism, or component 0 to 2; planar angular velocities have component 2
  T factor = 1;     ///< SI
  BodyId body = 0;  ///< for components of velocities of bodies
  Vector3Of<T> position = Vector3Of<T>::Zero();  ///< point whose velocity is meant, body axes [m]
  /// Multiplies the factor by a function of the joint coordinates `pose_variables`; none in constraints.
  VariableFunctionOf<T> pose_factor = {};
  std::vector<CoordinateId> pose_variables = {};
};

/// φ or ψ of P0 eq. 1. As a constraint, the sum of the terms equals `value`.
template <class T>
struct GeneralisedSpeedOf {
  std::string name;
  std::vector<GeneralisedSpeedTermOf<T>> terms;
  VariableFunctionOf<T> value = {};  ///< of a constraint: function of time [m/s or rad/s]; none: zero
};

using GeneralisedSpeedTerm = GeneralisedSpeedTermOf<double>;
using GeneralisedSpeed = GeneralisedSpeedOf<double>;

enum class SpaceKind { planar, spatial };

/// The rigid body that does not move; always bodies[0].
inline constexpr BodyId ground = 0;

/// A named point of a body, in the body's axes from the body's origin [m].
template <class T>
struct NamedPointOf {
  std::string name;
  Vector3Of<T> position;
};

/// bodies[0] is the ground (mass 0, inertia 0). Other bodies may be massless, or point masses (inertia 0).
template <class T>
struct BodyOf {
  std::string name;
  T mass = 0;                                   ///< [kg]
  Vector3Of<T> com = Vector3Of<T>::Zero();      ///< from the body's origin, body axes [m]
  Matrix3Of<T> inertia = Matrix3Of<T>::Zero();  ///< about the CoM, body axes [kg m^2]; off-diagonal entries are −∫xy dm
  std::vector<NamedPointOf<T>> points;
  bool inertia_as_given = false;  ///< validate() accepts the inertia although no body can have it
};

enum class JointType {
  revolute,
  prismatic,
  fixed,
  pin_slot,
  cylindrical,
  universal,
  spherical,
  planar,
  free,
  rolling_disc,
  rolling_sphere
};

/// A joint lets `second` move relative to `first`. At zero coordinates, `rotation` is the rotation of the second body's
/// frame in the first body's. With P = point_first, Q = point_second (each in its body's axes), u = axis, v = axis2
/// (unit vectors in the first body's axes) and r = Q − P:
///
/// | type        | coordinates  | motion                                                                    |
/// | ----------- | ------------ | ------------------------------------------------------------------------- |
/// | revolute    | angle        | r = 0; rotation about u                                                   |
/// | prismatic   | slide        | r = slide u; no rotation                                                  |
/// | fixed       | none         | r = 0; no rotation                                                        |
/// | pin_slot    | slide, angle | plane only: r = slide u; free rotation                                    |
/// | cylindrical | angle, slide | r = slide u; rotation about u                                             |
/// | universal   | 1, 2         | r = 0; rotation by the first about u, then by the second about the turned v |
/// | spherical   | 1, 2, 3      | r = 0; successive rotations about x, the turned y, the twice turned z     |
/// | planar      | x, y, angle  | r = x v + y (u × v); rotation about u, which is z in the plane             |
/// | free        | x, y, z,     | space only: r = (x, y, z); successive rotations as of a spherical joint     |
/// |             | 1, 2, 3      |                                                                           |
///
/// The next two types roll without slip on the plane through P. Its normal u points to the side of the rolling body,
/// whose centre is Q. They have five coordinates and two constraints on their rates: the material point in contact with
/// the plane is at rest.
///
/// | type           | coordinates                | motion                                                             |
/// | -------------- | -------------------------- | ------------------------------------------------------------------ |
/// | rolling_disc   | x, y, heading, lean, angle | contact at x v + y (u × v); rotations by heading about u, by lean  |
/// |                |                            | about the turned v (its heading direction), by angle about its own |
/// |                |                            | axis u × v                                                         |
/// | rolling_sphere | x, y, 1, 2, 3              | contact at x v + y (u × v); successive rotations about x, the      |
/// |                |                            | turned y, the twice turned z                                       |
template <class T>
struct JointOf {
  std::string name;
  JointType type = JointType::revolute;
  BodyId first = ground;
  BodyId second = ground;
  Vector3Of<T> point_first = Vector3Of<T>::Zero();
  Vector3Of<T> point_second = Vector3Of<T>::Zero();
  Vector3Of<T> axis = Vector3Of<T>::UnitZ();   ///< planar prismatic and pin_slot: direction of the slide
  Vector3Of<T> axis2 = Vector3Of<T>::UnitX();  ///< universal: second axis; planar, rolling: direction of x; else unused
  Matrix3Of<T> rotation = Matrix3Of<T>::Identity();
  T radius = 0;        ///< of the rolling body [m]
  bool slips = false;  ///< a rolling body only touches the plane: its rates are not constrained
};

/// Number of coordinates of a joint type.
int joint_degrees_of_freedom(JointType type);
/// A disc or a sphere on a plane.
bool is_rolling(JointType type);

/// What one coordinate of a joint measures.
enum class CoordinateKind { angle, length };

/// One scalar coordinate of a joint. Mechanism::coordinates lists them joint by joint.
struct Coordinate {
  std::string name;  ///< "J" if the joint has one coordinate, else "J.angle", "J.slide", "J.x", "J.1", …
  JointId joint = 0;
  int index = 0;  ///< within the joint
  CoordinateKind kind = CoordinateKind::angle;
};

/// ratio · q[coordinate].
template <class T>
struct CoordinateTermOf {
  CoordinateId coordinate = 0;
  T ratio = 1;
};

/// What a disc or a coupled coordinate follows: Σ ratio · q[coordinate] over different coordinates. A belt over several
/// joints has several terms; otherwise there is one, with ratio 1.
template <class T>
struct CoordinateCombinationOf {
  std::vector<CoordinateTermOf<T>> terms;

  CoordinateCombinationOf() : CoordinateCombinationOf(CoordinateId()) {}
  template <std::convertible_to<CoordinateId> Id>
  CoordinateCombinationOf(Id coordinate)
      : terms{{coordinate, T(1)}} {}  // NOLINT(google-explicit-constructor): usually a single coordinate
  explicit CoordinateCombinationOf(std::vector<CoordinateTermOf<T>> sum) : terms(std::move(sum)) {}

  /// @param q per coordinate of the mechanism: positions, rates or accelerations
  template <class Q>
  T evaluate(const Q& q) const {
    T sum = 0;
    for (const CoordinateTermOf<T>& term : terms) sum += term.ratio * q[term.coordinate];
    return sum;
  }
};

/// Gear or belt: q[follower] = ratio · leader.evaluate(q) + offset.
template <class T>
struct CouplingOf {
  CoordinateId follower = 0;
  CoordinateCombinationOf<T> leader;
  T ratio = 1;
  T offset = 0;
};

enum class ShapeKind { cylinder, ring, sector, plate };

/// A homogeneous solid. Its own axes have their origin at its centre of mass and z along the axis of revolution or, of
/// a plate, along its thickness; a sector is symmetric to the xz plane, with its arc on the side of +x.
template <class T>
struct ShapeOf {
  ShapeKind kind = ShapeKind::cylinder;
  T diameter = 0;                                    ///< cylinder, ring, sector: outer [m]
  T inner_diameter = 0;                              ///< ring, sector [m]
  T length = 0, width = 0;                           ///< plate: along x and y [m]
  T thickness = 0;                                   ///< along z [m]
  T opening = 0;                                     ///< sector: angle between its edges [rad]
  T axis_distance = 0;                               ///< sector: of the centre of mass from the arcs' axis [m]
  Matrix3Of<T> rotation = Matrix3Of<T>::Identity();  ///< from its own axes to those of the body that carries it
};

enum class AttachmentKind { counterweight, payload };

/// A mass (a point, or a body with inertia) fixed to a body.
template <class T>
struct AttachmentOf {
  std::string name;
  AttachmentKind kind = AttachmentKind::counterweight;
  BodyId body = 0;
  Vector3Of<T> position = Vector3Of<T>::Zero();            ///< of its CoM, in the body's axes [m]
  T mass = 0;                                              ///< [kg], zero allowed (a free mass may vanish)
  Matrix3Of<T> inertia = Matrix3Of<T>::Zero();             ///< about its CoM, in the body's axes [kg m^2]
  double from = -std::numeric_limits<double>::infinity();  ///< time of a trajectory at which it is taken up [s]
  double until = std::numeric_limits<double>::infinity();  ///< time at which it is set down [s], later than `from`
  std::optional<ShapeOf<T>> shape = {};                    ///< that gives it its mass and inertia
};

/// A rotor carried by a body at `position` (its CoM, on its axis). It turns relative to the carrier about `axis` by
/// ratio · follows.evaluate(q).
template <class T>
struct DiscOf {
  std::string name;
  BodyId body = 0;                               ///< the carrier
  Vector3Of<T> position = Vector3Of<T>::Zero();  ///< in the carrier's axes [m]
  Vector3Of<T> axis = Vector3Of<T>::UnitZ();     ///< unit vector in the carrier's axes
  CoordinateCombinationOf<T> follows;
  T ratio = 1;
  T mass = 0;                                   ///< [kg]
  Matrix3Of<T> inertia = Matrix3Of<T>::Zero();  ///< about its CoM, in the carrier's axes at coordinate zero [kg m^2]
};

enum class Frame { world, body };

/// An external force and moment on a body: constant (one entry), or a table over time or over a joint coordinate.
template <class T>
struct LoadOf {
  std::string name;
  BodyId body = 0;
  Vector3Of<T> point = Vector3Of<T>::Zero();  ///< where the force acts, in the body's axes [m]
  Frame frame = Frame::world;                 ///< axes in which force and moment are given
  std::vector<T> arguments;                   ///< increasing, of the table [s, rad or m]; empty for a constant load
  std::vector<Vector3Of<T>> force;            ///< one entry, or one per argument [N]
  std::vector<Vector3Of<T>> moment;           ///< same length as force [N m]
  CoordinateId coordinate = -1;               ///< the table's argument; −1: the time
  bool is_periodic = false;  ///< the last entry equals the first, one period later; else end values are held outside
  bool is_spline = false;    ///< a C² cubic spline between the entries (LoadTable); else straight lines

  bool is_over_time() const { return coordinate < 0 && !arguments.empty(); }
  bool is_over_coordinate() const { return coordinate >= 0; }
};

/// A linear spring between a point of each of two bodies, with tension stiffness · (length − free_length). With initial
/// tension F, that of its coils is by F/stiffness longer than this free length, which may be negative. Or a spring in a
/// joint coordinate q, torsional if q is an angle, with the effort preload − stiffness · q on q; bodies and points are
/// then unused.
template <class T>
struct SpringOf {
  std::string name;
  BodyId first = ground;
  BodyId second = ground;
  Vector3Of<T> point_first = Vector3Of<T>::Zero();
  Vector3Of<T> point_second = Vector3Of<T>::Zero();
  T stiffness = 0;               ///< [N/m]; on an angle [N m/rad]
  T free_length = 0;             ///< [m]; zero is a zero-free-length spring
  T preload = 0;                 ///< joint spring: effort on the coordinate at zero [N m or N]
  CoordinateId coordinate = -1;  ///< −1: spring between points
  /// Length up to which it is slack, because its coils are closed and it cannot push [m]; none: it may push.
  std::optional<T> slack_length = {};
  std::optional<T> shortest_length = {}, longest_length = {};  ///< travel for which it is made [m]; none: any

  bool is_joint_spring() const { return coordinate >= 0; }
  bool has_travel() const { return slack_length || shortest_length || longest_length; }
  /// Tension over length [N/m]: with it, the spring pulls along the vector between its points.
  T tension_per_length(const T& length) const {
    if (slack_length && !(length > *slack_length)) return T(0);
    if (free_length == 0) return stiffness;  // pulls even at zero length
    return length > 0 ? T(stiffness * (1 - free_length / length)) : T(0);
  }
  /// Stored energy [J]: zero at the free length or, of a spring that cannot push, where it becomes slack.
  T energy(const T& length) const {
    const T elongation = length - free_length;
    if (!slack_length) return 0.5 * stiffness * elongation * elongation;
    if (!(length > *slack_length)) return T(0);
    const T closed = *slack_length - free_length;
    return 0.5 * stiffness * (elongation * elongation - closed * closed);
  }
  /// Distance from the nearer end of the travel; negative beyond it, infinite without a travel [m].
  T travel_margin(const T& length) const {
    T margin = T(std::numeric_limits<double>::infinity());
    for (const std::optional<T>* least : {&shortest_length, &slack_length})
      if (*least && length - **least < margin) margin = length - **least;
    if (longest_length && *longest_length - length < margin) margin = *longest_length - length;
    return margin;
  }
};

/// A force between a point of each of two bodies, along the line through them: a damper, or a spring whose tension is a
/// table over its length. Or an effort on a joint coordinate that is a table over the coordinate; bodies and points are
/// then unused.
template <class T>
struct ForceElementOf {
  std::string name;
  BodyId first = ground;
  BodyId second = ground;
  Vector3Of<T> point_first = Vector3Of<T>::Zero();
  Vector3Of<T> point_second = Vector3Of<T>::Zero();
  CoordinateId coordinate = -1;  ///< −1: between points
  ForceTableOf<T> table;         ///< tension over length, or effort over coordinate; empty: a damper
  T damping = 0;                 ///< of a damper: tension per rate of the length [N s/m]

  bool is_in_joint() const { return coordinate >= 0; }
  bool is_damper() const { return table.is_empty(); }
};

/// Friction in a joint coordinate. Sliding, it resists with viscous · q̇ + dry_friction(sign(q̇)) · sign(q̇). At rest,
/// it holds efforts up to static_limit(). See mechanics/model/friction_law.hpp. Forward is the direction in which the
/// coordinate grows.
template <class T>
struct FrictionOf {
  CoordinateId coordinate = 0;
  T viscous = 0;                           ///< [N m s/rad] or [N s/m]
  T coulomb = 0;                           ///< forward [N m] or [N]
  std::optional<T> breakaway = {};         ///< effort to break loose, at least coulomb [N m or N]; none: coulomb
  std::optional<T> coulomb_backward = {};  ///< none: as forward
  std::optional<T> at_rest_backward = {};  ///< none: as forward if `breakaway` is given, else Coulomb friction backward

  /// Non-negative. @param sign of the rate
  T dry_friction(int sign) const { return sign < 0 && coulomb_backward ? *coulomb_backward : coulomb; }
  /// Largest effort held at rest. @param sign of the rate that friction prevents
  T static_limit(int sign) const {
    if (sign < 0 && at_rest_backward) return *at_rest_backward;
    return breakaway ? *breakaway : dry_friction(sign);
  }
};

/// How one actuator takes part in the distribution of efforts.
template <class T>
struct EffortShareOf {
  T weight = 1;                             ///< > 0, of the actuator's term in what is minimised
  std::optional<T> lower = {}, upper = {};  ///< least and largest effort [N m or N]
  std::optional<T> preload = {};  ///< not zero: the effort keeps this sign and at least this magnitude [N m or N]

  /// The larger of `lower` and a positive preload.
  std::optional<T> lower_bound() const {
    if (!preload || !(*preload > 0) || (lower && *lower > *preload)) return lower;
    return preload;
  }
  /// The smaller of `upper` and a negative preload.
  std::optional<T> upper_bound() const {
    if (!preload || !(*preload < 0) || (upper && *upper < *preload)) return upper;
    return preload;
  }
};

/// What the efforts minimise at every moment. An effort counts as a moment: a force times the characteristic length.
enum class DistributionMethod {
  min_norm,  ///< Σ weight · effort²
  min_peak,  ///< the largest weight · |effort|; of all efforts with the same largest one, Σ (weight · effort)²
};

/// Which efforts more actuators than degrees of freedom exert. Where none are within the bounds, the largest excess over
/// a bound is the least possible.
template <class T>
struct TorqueDistributionOf {
  DistributionMethod method = DistributionMethod::min_norm;
  std::vector<EffortShareOf<T>> shares;  ///< one per actuator

  bool is_weighted() const {
    for (const EffortShareOf<T>& share : shares)
      if (!(share.weight == shares.front().weight)) return true;
    return false;
  }
  bool has_limits() const {
    for (const EffortShareOf<T>& share : shares)
      if (share.lower || share.upper) return true;
    return false;
  }
  bool has_preload() const {
    for (const EffortShareOf<T>& share : shares)
      if (share.preload) return true;
    return false;
  }
  /// Whether the efforts are a linear function of the generalised forces.
  bool is_linear() const { return method == DistributionMethod::min_norm && !has_limits() && !has_preload(); }
};

/// Point of interest of one body.
template <class T>
struct ToolOf {
  BodyId body = 0;
  std::string point;                             ///< name of the point on the body
  Vector3Of<T> position = Vector3Of<T>::Zero();  ///< in the body's axes [m]
};

/// Approximate value of a joint coordinate, used to select the assembly mode.
template <class T>
struct CoordinateValueOf {
  CoordinateId coordinate = 0;
  T value = 0;
};

template <class T>
struct MechanismOf {
  std::string name;
  SpaceKind space = SpaceKind::planar;
  Vector3Of<T> gravity = Vector3Of<T>::Zero();  ///< [m/s^2]
  std::vector<BodyOf<T>> bodies;                ///< bodies[0] is the ground
  std::vector<JointOf<T>> joints;
  std::vector<Coordinate> coordinates;  ///< of all joints, in order: list_coordinates(joints)
  std::vector<CouplingOf<T>> couplings;
  std::vector<GeneralisedSpeedOf<T>> constraints;  ///< speeds that are zero, or the given functions of time
  std::vector<AttachmentOf<T>> attachments;
  std::vector<DiscOf<T>> discs;
  std::vector<LoadOf<T>> loads;
  std::vector<SpringOf<T>> springs;
  std::vector<ForceElementOf<T>> force_elements;
  std::vector<FrictionOf<T>> friction;
  std::vector<CoordinateId> actuators;                         ///< actuated coordinates
  std::optional<TorqueDistributionOf<T>> torque_distribution;  ///< none: least norm, without weights and bounds
  std::optional<ToolOf<T>> tool;
  std::vector<CoordinateValueOf<T>> assembly;
  DisplayUnits units;  ///< for messages and reports
};

// Plain values. Over dual numbers (foundation/base/dual.hpp) a mechanism also carries derivatives.
using NamedPoint = NamedPointOf<double>;
using Body = BodyOf<double>;
using Joint = JointOf<double>;
using CoordinateTerm = CoordinateTermOf<double>;
using CoordinateCombination = CoordinateCombinationOf<double>;
using Coupling = CouplingOf<double>;
using Shape = ShapeOf<double>;
using Attachment = AttachmentOf<double>;
using Disc = DiscOf<double>;
using Load = LoadOf<double>;
using Spring = SpringOf<double>;
using ForceElement = ForceElementOf<double>;
using Friction = FrictionOf<double>;
using EffortShare = EffortShareOf<double>;
using TorqueDistribution = TorqueDistributionOf<double>;
using Tool = ToolOf<double>;
using CoordinateValue = CoordinateValueOf<double>;
using Mechanism = MechanismOf<double>;

/// The coordinates of all joints, joint by joint, with their names.
std::vector<Coordinate> list_coordinates(SpaceKind space, const std::vector<Joint>& joints);

/// Whether some rates are constrained and positions are not: a body rolls on a plane, or there are constraints on
/// speeds.
bool has_velocity_constraints(const Mechanism& mechanism);

/// Whether a constraint on speeds has a value other than zero, so that its force does work.
bool has_prescribed_speeds(const Mechanism& mechanism);

/// "least norm", "least weighted peak within limits and with preload".
template <class T>
std::string describe_distribution(const std::optional<TorqueDistributionOf<T>>& distribution) {
  if (!distribution) return "least norm";
  std::string text = distribution->is_weighted() ? "least weighted " : "least ";
  text += distribution->method == DistributionMethod::min_norm ? "norm" : "peak";
  if (distribution->has_limits()) text += " within limits";
  if (distribution->has_preload()) text += distribution->has_limits() ? " and with preload" : " with preload";
  return text;
}

/// Whether the efforts are a linear function of the generalised forces, however many actuators there are.
inline bool has_linear_efforts(const Mechanism& mechanism) {
  return !mechanism.torque_distribution || mechanism.torque_distribution->is_linear();
}

/// Name of a method in the spec language.
inline const char* name_of(DistributionMethod method) {
  return method == DistributionMethod::min_norm ? "least-norm" : "least-peak";
}

/// Characteristic length: the largest distance of a named or joint point from its body's origin or, for the ground,
/// between two of its points. Always positive. All comparisons with zero are scaled by it.
double characteristic_length(const Mechanism& mechanism);

/// Largest distance of a ground joint point from the world origin, in characteristic lengths; at least 1. Round-off of
/// loop closures is proportional to it.
double ground_extent(const Mechanism& mechanism);

/// Total moving mass: bodies, attachments and discs [kg].
double total_mass(const Mechanism& mechanism);

/// Whether a joint coordinate is a length; otherwise it is an angle.
inline bool is_length_coordinate(const Mechanism& mechanism, CoordinateId c) {
  return mechanism.coordinates[static_cast<std::size_t>(c)].kind == CoordinateKind::length;
}

/// "120 deg". @param value [rad or m] @param round_off magnitudes up to this become 0 [rad or m]
inline std::string format_coordinate(const Mechanism& mechanism, CoordinateId c, double value, double round_off = 0) {
  return is_length_coordinate(mechanism, c) ? format_length(value, mechanism.units, round_off)
                                            : format_angle(value, mechanism.units, round_off);
}

/// Sets coordinates of a pose that are round-off to 0.
/// @param values all coordinates
/// @param length characteristic length [m]
template <class Values>
void clear_pose_round_off(const Mechanism& mechanism, double length, Values& values) {
  for (std::size_t c = 0; c < mechanism.coordinates.size(); ++c) {
    double& value = values[static_cast<Eigen::Index>(c)];
    if (std::abs(value) < pose_round_off * (is_length_coordinate(mechanism, static_cast<int>(c)) ? length : 1))
      value = 0;
  }
}

// Equations of motion in user-chosen generalised speeds.

/// Speeds that describe the motion, and speeds constrained to zero in addition to the mechanism's own constraints.
struct SpeedChoice {
  std::vector<GeneralisedSpeed> speeds, constrained;
};

// Joints of bodies and coordinates of joints.

/// The joints of each body, in the mechanism's order.
std::vector<std::vector<JointId>> joints_of_bodies(const Mechanism& mechanism);

/// The coordinates of each joint, in the joint's order.
std::vector<std::vector<CoordinateId>> coordinates_of_joints(const Mechanism& mechanism);

/// Name of a joint type in the spec language.
inline const char* name_of(JointType type) {
  switch (type) {
    case JointType::revolute: return "revolute";
    case JointType::prismatic: return "prismatic";
    case JointType::fixed: return "fixed";
    case JointType::pin_slot: return "pin-slot";
    case JointType::cylindrical: return "cylindrical";
    case JointType::universal: return "universal";
    case JointType::spherical: return "spherical";
    case JointType::planar: return "planar";
    case JointType::free: return "free";
    case JointType::rolling_disc:
    case JointType::rolling_sphere: return "rolling";
  }
  return "";
}

// Union of mechanisms.

/// Joins mechanisms that share only the ground. Concatenates their lists; names do not change. Space, gravity and tool
/// are those of the first mechanism; there is no torque distribution. What must vanish for all motions of the union must vanish for all motions of each
/// mechanism.
/// @throws std::invalid_argument if `mechanisms` is empty, or if space or gravity differ
Mechanism disjoint_union(const std::vector<Mechanism>& mechanisms);

/// One of the mechanisms of a union whose lists all have the same lengths.
/// @param like any of them: for names of coordinates and for what the union does not keep; the tool's place is that of its
///        point in the part
/// @param part 0 for the first
Mechanism extract_part(const Mechanism& united, const Mechanism& like, std::size_t part);

}  // namespace balance::model

namespace balance {

using model::Attachment;
using model::AttachmentKind;
using model::Body;
using model::BodyId;
using model::Coordinate;
using model::CoordinateId;
using model::CoordinateKind;
using model::CoordinateValue;
using model::Coupling;
using model::Disc;
using model::ForceElement;
using model::Friction;
using model::Joint;
using model::JointId;
using model::JointType;
using model::list_coordinates;
using model::Load;
using model::Mechanism;
using model::MechanismOf;
using model::SpaceKind;
using model::Spring;
using model::Tool;
using model::TorqueDistribution;

}  // namespace balance
