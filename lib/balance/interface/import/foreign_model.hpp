#pragma once
/// A mechanism as a foreign file tells it, before names and bodies become those of a spec. SI units.
///
/// Bodies and joints keep their index when they are merged or left out: `kept` says whether they are still there.

#include "balance/foundation/base/error.hpp"
#include "balance/interface/import/import.hpp"
#include "balance/mechanics/model/mechanism.hpp"

#include <map>
#include <optional>
#include <string>
#include <vector>

namespace balance::foreign {

/// Where a body's frame lies in another's.
struct Pose {
  Matrix3 R = Matrix3::Identity();
  Vector3 p = Vector3::Zero();

  Pose operator*(const Pose& next) const { return {R * next.R, p + R * next.p}; }
  Pose inverse() const { return {R.transpose(), -(R.transpose() * p)}; }
};

/// A body that became part of another.
struct MergedBody {
  int body = 0;
  Pose pose;  ///< in the other
};

/// bodies[0] is what does not move.
struct ForeignBody {
  Body body;  ///< named places are frames of the file
  SourceLocation place;
  bool is_active = true;
  std::vector<MergedBody> merged_bodies = {};  ///< what was merged into it
  bool has_inertial = false;                   ///< the file says mass and inertia
  bool has_geometry = false;                   ///< the file says what it looks like
  bool has_unknown_mass = false;               ///< its mass would follow from shapes that are not read
  bool is_marker = false;                      ///< it only marks a place; its mass was left out
};

/// What the file allows a coordinate; for comments.
struct JointLimits {
  std::optional<double> lower, upper, rate, effort;
};

struct ForeignJoint {
  Joint joint;
  SourceLocation place;
  bool is_active = true;
  bool is_loop_closure = false;     ///< said as a closure, not as a joint of the tree
  bool is_floating = false;         ///< six freedoms, for which there is no type; `joint` is fixed then
  bool is_actuated = false;         ///< it has a motor
  std::string actuated_coordinate;  ///< which of its coordinates has it, `slide`; empty: all
  std::optional<Vector3> rpy;       ///< what joint.rotation was written as
  JointLimits limits;
  double viscous = 0, coulomb = 0;             ///< friction of its only coordinate
  double stiffness = 0, spring_reference = 0;  ///< of a spring in it
  double armature = 0;                         ///< inertia of a geared rotor, seen at the joint
  std::string note;                            ///< a comment for the spec
};

/// q[follower] = ratio q[leader] + offset, of joints with one coordinate.
struct ForeignCoupling {
  int follower = 0, leader = 0;
  double ratio = 1, offset = 0;
  SourceLocation place;
};

/// Counted by what was left out: "visual", "collision".
using IgnoredCounts = std::map<std::string, int>;

struct ForeignModel {
  std::string name, format, file;
  SpaceKind space = SpaceKind::spatial;
  Vector3 gravity = Vector3(0, 0, -9.81);
  std::vector<ForeignBody> bodies;
  std::vector<ForeignJoint> joints;
  std::vector<ForeignCoupling> couplings;
  std::vector<Spring> springs;      ///< bodies by index here
  bool declares_actuators = false;  ///< the file says which joints are driven
  IgnoredCounts ignored;
  std::vector<Finding> findings;

  /// −1 if there is none of that name.
  int find_body(const std::string& wanted) const;
  int find_joint(const std::string& wanted) const;
};

/// Of a joint's second body in its first, at zero.
Pose joint_zero_pose(const Joint& joint);

/// The same joint seen from its other body, with the same coordinate. Only for types with at most one axis.
Joint reverse_joint(const Joint& joint);

// Loops that are said apart from a tree: which two frames meet, and how.

/// A frame fixed to a body.
struct BodyFrame {
  int body = 0;
  Pose pose;  ///< in the body
};

/// Adds the joint that lets the second frame move against the first; at zero they coincide.
/// @param axis in the frames' axes; unit
void add_loop_joint(ForeignModel& robot, const std::string& name, JointType type, const BodyFrame& first,
                    const BodyFrame& second, const Vector3& axis, const SourceLocation& place);

/// Poses of all bodies in bodies[0] when every joint of the tree is at zero; closures are not looked at.
std::vector<Pose> zero_configuration_poses(const ForeignModel& robot);

/// A Gepetto loop file: `closed_loop: [[A, B], …]` names frames (a joint's is its child's), `type: [6d, 3d]` how they meet,
/// `name_mot: […]` the driven joints.
/// @throws SpecError with everything that is wrong
void read_gepetto_loops(const std::string& text, const std::string& file, ForeignModel& robot);

/// Bodies without anything on them that only mark where a closure is, carried by the joint that the closure names: they lose
/// their mass. Told.
void clear_marker_masses(ForeignModel& robot, const std::vector<int>& named_bodies);

}  // namespace balance::foreign
