#pragma once
/// A mechanism as its designer wrote it: bodies connected by joints to each other and to the ground. Plain
/// values; indices instead of names; never changed by an algorithm. SI units throughout.
///
/// Planar mechanisms use the same types: positions have z = 0, axes of rotation are z, an inertia has only its zz entry.

#include "balance/foundation/base/id.hpp"
#include "balance/foundation/base/types.hpp"

#include <cmath>
#include <concepts>
#include <cstddef>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace balance {

// Indices into a mechanism's lists.

using BodyId = TypedIndex<struct BodyList>;              ///< into Mechanism::bodies
using JointId = TypedIndex<struct JointList>;            ///< into Mechanism::joints
using CoordinateId = TypedIndex<struct CoordinateList>;  ///< into Mechanism::coordinates

/// The units that a mechanism's designer thinks in, for what is said to him. All numbers are kept in SI.
struct DisplayUnits {
  double length = 1;  ///< [m]
  double angle = 1;   ///< [rad]
  std::string length_name = "m", angle_name = "rad";
};

/// Coordinates of a pose are found no better than this, in radians or characteristic lengths.
inline constexpr double pose_round_off = 1e-12;

/// "350 mm". @param value [m] @param round_off values no larger become 0 [m]
std::string format_length(double value, const DisplayUnits& units, double round_off = 0);
/// "120 deg". @param value [rad] @param round_off values no larger become 0 [rad]
std::string format_angle(double value, const DisplayUnits& units, double round_off = 0);
/// "(350, 0) mm". @param place its components [m] @param count 2 or 3
std::string format_position(const double* place, int count, const DisplayUnits& units, double round_off = 0);

// Speeds that need not be rates of coordinates: sums of rates of joint coordinates and of components of bodies' motion.

/// factor · (what it is of). Own: in the axes of the body, which move.
template <class T>
struct GeneralisedSpeedTermOf {
  enum class Kind { coordinate, velocity, velocity_body, angular_velocity, angular_velocity_body };
  Kind kind = Kind::coordinate;
  int index = 0;    ///< coordinate of the mechanism, or component 0 to 2; what turns in the plane has component 2
  T factor = 1;     ///< SI
  BodyId body = 0;  ///< of a component
  Vector3Of<T> position = Vector3Of<T>::Zero();  ///< of the point whose velocity is meant, in the body's axes [m]
};

/// φ or ψ of P0 eq. 1 with constant factors.
template <class T>
struct GeneralisedSpeedOf {
  std::string name;
  std::vector<GeneralisedSpeedTermOf<T>> terms;
};

using GeneralisedSpeedTerm = GeneralisedSpeedTermOf<double>;
using GeneralisedSpeed = GeneralisedSpeedOf<double>;

enum class SpaceKind { planar, spatial };

/// The rigid body that does not move; always bodies[0].
inline constexpr BodyId ground = 0;

/// A named place on a body, in the body's axes from the body's origin [m].
template <class T>
struct NamedPointOf {
  std::string name;
  Vector3Of<T> position;
};

/// bodies[0] is the ground (mass 0, inertia 0); others may be without both, or point masses (inertia 0).
template <class T>
struct BodyOf {
  std::string name;
  T mass = 0;                                   ///< [kg]
  Vector3Of<T> com = Vector3Of<T>::Zero();      ///< from the body's origin, body axes [m]
  Matrix3Of<T> inertia = Matrix3Of<T>::Zero();  ///< about the CoM, body axes [kg m^2]; off-diagonal entries are −∫xy dm
  std::vector<NamedPointOf<T>> points;
  bool inertia_as_given = false;  ///< no body can have it, and it is meant all the same: validate() lets it pass
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
  rolling_disc,
  rolling_sphere
};

/// A joint lets `second` move relative to `first`. At coordinates zero the second body's frame has the rotation
/// `rotation` in the first one's. With P = point_first, Q = point_second (each in its body's axes), u = axis, v = axis2
/// (unit vectors in the first body's axes) and r = Q − P:
///
/// | type        | coordinates  | motion                                                                    |
/// | ----------- | ------------ | ------------------------------------------------------------------------- |
/// | revolute    | angle        | r = 0; rotation about u                                                   |
/// | prismatic   | slide        | r = slide u; no rotation                                                  |
/// | fixed       | none         | r = 0; no rotation                                                        |
/// | pin_slot    | slide, angle | planar: r = slide u; free rotation                                        |
/// | cylindrical | angle, slide | r = slide u; rotation about u                                             |
/// | universal   | 1, 2         | r = 0; rotation by the first about u, then by the second about the turned v |
/// | spherical   | 1, 2, 3      | r = 0; successive rotations about x, the turned y, the twice turned z     |
/// | planar      | x, y, angle  | r = x v + y (u × v); rotation about u                                     |
///
/// The last two types roll without slip on the plane through P whose normal u points to their side; Q is the centre, n the plane's
/// normal. They have five coordinates, whose rates are bound to each other twice: the material point in touch with the plane rests on it.
///
/// | type           | coordinates                | motion                                                                   |
/// | -------------- | -------------------------- | ------------------------------------------------------------------------ |
/// | rolling_disc   | x, y, heading, lean, angle | touches at x v + y (u × v); rotations by heading about u, by lean about  |
/// |                |                            | the turned v, which is where it heads, by angle about its own axis u × v |
/// | rolling_sphere | x, y, 1, 2, 3              | touches at x v + y (u × v); rotations about x, the turned y, the twice   |
/// |                |                            | turned z                                                                 |
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
  T radius = 0;        ///< of what rolls [m]
  bool slips = false;  ///< what rolls only touches the plane: its rates are not bound
};

/// Number of coordinates of a joint type.
int joint_degrees_of_freedom(JointType type);
/// A disc or a sphere on a plane.
bool is_rolling(JointType type);

/// What one coordinate of a joint measures.
enum class CoordinateKind { angle, length };

/// One scalar coordinate of a joint. Mechanism::coordinates lists them joint by joint.
struct Coordinate {
  std::string name;  ///< "J" where the joint has one coordinate, else "J.angle", "J.slide", "J.x", "J.1", …
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

/// What a disc or a coupled coordinate follows: Σ ratio · q[coordinate], of different coordinates; of a belt over several joints
/// more than one, else one with the ratio 1.
template <class T>
struct CoordinateCombinationOf {
  std::vector<CoordinateTermOf<T>> terms;

  CoordinateCombinationOf() : CoordinateCombinationOf(CoordinateId()) {}
  template <std::convertible_to<CoordinateId> Id>
  CoordinateCombinationOf(Id coordinate)
      : terms{{coordinate, T(1)}} {}  // NOLINT(google-explicit-constructor): mostly it is one
  explicit CoordinateCombinationOf(std::vector<CoordinateTermOf<T>> sum) : terms(std::move(sum)) {}

  /// @param q per coordinate of the mechanism: positions, rates or accelerations
  template <class Q>
  T evaluate(const Q& q) const {
    T sum = 0;
    for (const CoordinateTermOf<T>& term : terms) sum += term.ratio * q[term.coordinate];
    return sum;
  }
};

/// Gear or belt: q[follower] = ratio · (what the leader says) + offset.
template <class T>
struct CouplingOf {
  CoordinateId follower = 0;
  CoordinateCombinationOf<T> leader;
  T ratio = 1;
  T offset = 0;
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
  double from = -std::numeric_limits<double>::infinity();  ///< taken up at that time of a trajectory [s]
  double until = std::numeric_limits<double>::infinity();  ///< set down at that time [s], later than from
};

/// A rotor carried by a body at `position` (its CoM, on its axis), turning relative to it about `axis` by ratio times what
/// it follows.
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

/// A force and a moment that the surroundings apply to a body. Constant (one row) or piecewise linear in time.
template <class T>
struct LoadOf {
  std::string name;
  BodyId body = 0;
  Vector3Of<T> point = Vector3Of<T>::Zero();  ///< where the force acts, in the body's axes [m]
  Frame frame = Frame::world;                 ///< axes in which force and moment are given
  std::vector<T> time;                        ///< empty for a constant load, else increasing [s]; held beyond its ends
  std::vector<Vector3Of<T>> force;            ///< one entry, or one per time [N]
  std::vector<Vector3Of<T>> moment;           ///< same length as force [N m]
};

/// A linear spring between a point of each of two bodies: tension stiffness · (length − free_length). Or in a joint coordinate q,
/// a torsion spring where that is an angle: it drives q with preload − stiffness · q, and bodies and points mean nothing.
template <class T>
struct SpringOf {
  std::string name;
  BodyId first = ground;
  BodyId second = ground;
  Vector3Of<T> point_first = Vector3Of<T>::Zero();
  Vector3Of<T> point_second = Vector3Of<T>::Zero();
  T stiffness = 0;               ///< [N/m], in an angle [N m/rad]
  T free_length = 0;             ///< [m]; zero is a zero-free-length spring
  T preload = 0;                 ///< in a joint: what it drives the coordinate with at zero [N m or N]
  CoordinateId coordinate = -1;  ///< −1: between its points

  bool is_joint_spring() const { return coordinate >= 0; }
};

/// Friction in a joint coordinate: it resists with viscous · q̇ + dry(sign(q̇)) · sign(q̇); at rest it holds against as much as
/// static_limit() (mechanics/model/friction_law.hpp has the law). Forwards is where the coordinate grows.
template <class T>
struct FrictionOf {
  CoordinateId coordinate = 0;
  T viscous = 0;                           ///< [N m s/rad] or [N s/m]
  T coulomb = 0;                           ///< forwards [N m] or [N]
  std::optional<T> breakaway = {};         ///< what it takes to break loose, at least coulomb [N m or N]; none: coulomb
  std::optional<T> coulomb_backward = {};  ///< none: as forwards
  std::optional<T> at_rest_backward = {};  ///< none: as forwards where that is stated, else coulomb backwards

  /// Not negative. @param sign of the rate
  T dry_friction(int sign) const { return sign < 0 && coulomb_backward ? *coulomb_backward : coulomb; }
  /// @param sign of the rate that it keeps from growing
  T static_limit(int sign) const {
    if (sign < 0 && at_rest_backward) return *at_rest_backward;
    return breakaway ? *breakaway : dry_friction(sign);
  }
};

/// The point of interest of one body.
template <class T>
struct ToolOf {
  BodyId body = 0;
  std::string point;                             ///< its name on the body
  Vector3Of<T> position = Vector3Of<T>::Zero();  ///< in the body's axes [m]
};

/// A rough value of one joint coordinate that helps to pick the assembly mode.
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
  std::vector<GeneralisedSpeedOf<T>> constraints;  ///< speeds that are always zero
  std::vector<AttachmentOf<T>> attachments;
  std::vector<DiscOf<T>> discs;
  std::vector<LoadOf<T>> loads;
  std::vector<SpringOf<T>> springs;
  std::vector<FrictionOf<T>> friction;
  std::vector<CoordinateId> actuators;  ///< coordinates that a motor drives
  std::optional<ToolOf<T>> tool;
  std::vector<CoordinateValueOf<T>> assembly;
  DisplayUnits units;  ///< of what is said of it
};

// As its designer wrote it. Over other scalars (foundation/base/dual.hpp) the same mechanism is known with its derivatives.
using NamedPoint = NamedPointOf<double>;
using Body = BodyOf<double>;
using Joint = JointOf<double>;
using CoordinateTerm = CoordinateTermOf<double>;
using CoordinateCombination = CoordinateCombinationOf<double>;
using Coupling = CouplingOf<double>;
using Attachment = AttachmentOf<double>;
using Disc = DiscOf<double>;
using Load = LoadOf<double>;
using Spring = SpringOf<double>;
using Friction = FrictionOf<double>;
using Tool = ToolOf<double>;
using CoordinateValue = CoordinateValueOf<double>;
using Mechanism = MechanismOf<double>;

/// The coordinates of all joints, joint by joint, with their names.
std::vector<Coordinate> list_coordinates(SpaceKind space, const std::vector<Joint>& joints);

/// Some rates are bound to each other where places are not: something rolls on a plane, or there are constraints on speeds.
bool has_velocity_constraints(const Mechanism& mechanism);

/// A length that is typical of the mechanism: the largest distance of a named or joint point from its body's
/// origin or, for the ground, between two of its points; positive. It scales every comparison with zero.
double characteristic_length(const Mechanism& mechanism);

/// Largest distance of a joint's place on the ground from the world's origin, in characteristic lengths, at least 1: what the
/// round-off of closures is proportional to.
double ground_extent(const Mechanism& mechanism);

/// Mass of everything that moves: bodies, attachments, discs [kg].
double total_mass(const Mechanism& mechanism);

/// Joint coordinates as lengths and angles.
inline bool is_length_coordinate(const Mechanism& mechanism, CoordinateId c) {
  return mechanism.coordinates[static_cast<std::size_t>(c)].kind == CoordinateKind::length;
}

/// "120 deg". @param value [rad or m] @param round_off values no larger become 0 [rad or m]
inline std::string format_coordinate(const Mechanism& mechanism, CoordinateId c, double value, double round_off = 0) {
  return is_length_coordinate(mechanism, c) ? format_length(value, mechanism.units, round_off)
                                            : format_angle(value, mechanism.units, round_off);
}

/// Coordinates of a pose that are round-off become 0. @param values of all coordinates @param length characteristic [m]
template <class Values>
void clear_pose_round_off(const Mechanism& mechanism, double length, Values& values) {
  for (std::size_t c = 0; c < mechanism.coordinates.size(); ++c) {
    double& value = values[static_cast<Eigen::Index>(c)];
    if (std::abs(value) < pose_round_off * (is_length_coordinate(mechanism, static_cast<int>(c)) ? length : 1))
      value = 0;
  }
}

// The equation of motion in speeds of one's own choice.

/// What is called the motion's speeds, and what is kept at zero besides the mechanism's own constraints.
struct SpeedChoice {
  std::vector<GeneralisedSpeed> speeds, constrained;
};

// Which parts of a mechanism belong to which.

/// Per body its joints, in their order.
std::vector<std::vector<JointId>> joints_of_bodies(const Mechanism& mechanism);

/// Per joint its coordinates, in their order.
std::vector<std::vector<CoordinateId>> coordinates_of_joints(const Mechanism& mechanism);

/// What a spec calls the types of joints.
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
    case JointType::rolling_disc:
    case JointType::rolling_sphere: return "rolling";
  }
  return "";
}

// Several mechanisms as one.

/// Mechanisms on one ground that do not touch each other: one after the other in every list, names as they are. Space and gravity are
/// the first one's, and so is the tool. What must vanish for all motions of the whole must vanish for all motions of each.
/// @throws std::invalid_argument if there is none, or if space or gravity differ
Mechanism disjoint_union(const std::vector<Mechanism>& mechanisms);

}  // namespace balance
