#pragma once
/// Mechanism as a foreign file describes it, before its names and bodies become those of a spec. SI units.
///
/// Bodies and joints keep their index when they are merged or left out: `is_active` is false for those.

#include "balance/foundation/base/error.hpp"
#include "balance/interface/import/import.hpp"
#include "balance/mechanics/model/mechanism.hpp"

#include <map>
#include <optional>
#include <string>
#include <vector>

namespace balance::foreign {

/// Pose of a body's frame in another body's frame.
struct Pose {
  Matrix3 R = Matrix3::Identity();
  Vector3 p = Vector3::Zero();

  Pose operator*(const Pose& next) const { return {R * next.R, p + R * next.p}; }
  Pose inverse() const { return {R.transpose(), -(R.transpose() * p)}; }
};

/// A body that was merged into another.
struct MergedBody {
  int body = 0;
  Pose pose;  ///< in the other's frame
};

/// bodies[0] is the ground.
struct ForeignBody {
  Body body;  ///< named points are frames of the file
  SourceLocation place;
  bool is_active = true;
  std::vector<MergedBody> merged_bodies = {};  ///< bodies merged into it
  bool has_inertial = false;                   ///< the file gives mass and inertia
  bool has_geometry = false;                   ///< the file gives its shape
  bool has_unknown_mass = false;               ///< its mass would follow from shapes that are not read
  bool is_marker = false;                      ///< it only marks a position; its mass was left out
};

/// Limits of a coordinate in the file; used for comments only.
struct JointLimits {
  std::optional<double> lower, upper, rate, effort;
};

struct ForeignJoint {
  Joint joint;
  SourceLocation place;
  bool is_active = true;
  bool is_loop_closure = false;     ///< given as a loop closure, not as a joint of the tree
  bool is_floating = false;         ///< six degrees of freedom, for which there is no joint type; `joint` is fixed then
  bool is_actuated = false;         ///< has a motor
  std::string actuated_coordinate;  ///< which of its coordinates has the motor, `slide`; empty: all
  std::optional<Vector3> rpy;       ///< roll-pitch-yaw angles by which the file gives joint.rotation
  JointLimits limits;
  double viscous = 0, coulomb = 0;             ///< friction of its only coordinate
  double stiffness = 0, spring_reference = 0;  ///< of a spring at the joint
  double armature = 0;                         ///< inertia of a geared rotor, reflected to the joint
  std::string note;                            ///< comment for the spec
};

/// q[follower] = ratio q[leader] + offset, for joints with one coordinate.
struct ForeignCoupling {
  int follower = 0, leader = 0;
  double ratio = 1, offset = 0;
  SourceLocation place;
};

/// A spring between points, with a damper beside it.
struct ForeignSpring : Spring {
  double damping = 0;  ///< [N s/m]
};

/// Number of elements left out, by kind: "visual", "collision".
using IgnoredCounts = std::map<std::string, int>;

struct ForeignModel {
  std::string name, format, file;
  SpaceKind space = SpaceKind::spatial;
  Vector3 gravity = Vector3(0, 0, -9.81);
  std::vector<ForeignBody> bodies;
  std::vector<ForeignJoint> joints;
  std::vector<ForeignCoupling> couplings;
  std::vector<ForeignSpring> springs;  ///< their bodies are indices into `bodies`
  bool declares_actuators = false;     ///< the file names the driven joints
  IgnoredCounts ignored;
  std::vector<Finding> findings;

  /// Returns −1 if no active body or joint has that name.
  int find_body(const std::string& body_name) const;
  int find_joint(const std::string& joint_name) const;
};

/// Pose of a joint's second body in its first one, at zero coordinates.
Pose joint_zero_pose(const Joint& joint);

/// The same joint with its bodies exchanged, and with the same coordinate. Only for types with at most one axis.
Joint reverse_joint(const Joint& joint);

// Loop closures given outside a tree: which two frames meet, and by which joint.

/// A frame fixed to a body.
struct BodyFrame {
  int body = 0;
  Pose pose;  ///< in the body
};

/// Adds the joint by which the second frame moves relative to the first; the frames coincide at zero.
/// @param axis unit vector in the axes of the first frame
void add_loop_joint(ForeignModel& robot, const std::string& name, JointType type, const BodyFrame& first,
                    const BodyFrame& second, const Vector3& axis, const SourceLocation& place);

/// Poses of all bodies in bodies[0] with every joint of the tree at zero. Ignores loop closures.
std::vector<Pose> zero_configuration_poses(const ForeignModel& robot);

/// Reads a Gepetto loop file: `closed_loop: [[A, B], …]` names frames (a joint stands for its child link),
/// `type: [6d, 3d]` how they meet, `name_mot: […]` the driven joints.
/// @throws SpecError listing everything that is wrong
void read_gepetto_loops(const std::string& text, const std::string& file, ForeignModel& robot);

/// Clears the mass of named bodies that carry nothing and only mark where a loop closes. Reports each of them.
/// @param named_bodies links that the closures name, directly or by the joint that carries them
void clear_marker_masses(ForeignModel& robot, const std::vector<int>& named_bodies);

}  // namespace balance::foreign
