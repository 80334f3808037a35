#pragma once
/// The links of a RobotTree with at most one joint each, for SDF and URDF: a link's frame is where its joint's axis is,
/// and links without mass stand between the joints of one body.

#include "balance/interface/import/robot_tree.hpp"

#include <string>
#include <vector>

namespace balance::foreign {

struct AxisLink {
  std::string name, joint_name;
  int parent = ground_link;           ///< index of an earlier link
  Pose pose;                          ///< at zero coordinates, in the world
  const RobotJoint* joint = nullptr;  ///< none: fixed to its parent
  const RobotLink* link = nullptr;    ///< whose mass it carries; none: it stands between two joints

  /// A place in the body's frame, in this link's frame.
  Vector3 place(const Vector3& in_body) const { return in_body + pose.R.transpose() * (link->pose.p - pose.p); }
};

/// @param tree at zero coordinates; must outlive the chain
std::vector<AxisLink> list_axis_links(const RobotTree& tree);

/// Roll, pitch and yaw of Rz(yaw) Ry(pitch) Rx(roll) [rad].
Vector3 rpy_of(const Matrix3& rotation);

/// "joint 'C' closes a loop: point (0.1, 0, 0) of 'b' and 'c'", for comments.
std::vector<std::string> describe_closures(const RobotTree& tree);

/// Of a link in its parent, at zero coordinates.
Pose relative_pose(const std::vector<AxisLink>& links, const AxisLink& link);

/// nullptr: the joint has none.
const RobotMotor* find_motor(const RobotTree& tree, const std::string& joint);

/// Adds couplings to several joints, which these formats lack, to what is missing.
void report_split_couplings(const RobotTree& tree, std::vector<std::string>& missing);

/// Adds springs between points, which these formats lack, to what is missing.
void report_point_springs(const RobotTree& tree, std::vector<std::string>& missing);

}  // namespace balance::foreign
