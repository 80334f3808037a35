#include "balance/import/closures.hpp"

#include <fmt/format.h>

namespace balance::foreign {

void add_loop_joint(ForeignModel& robot, const std::string& name, JointType type, const BodyFrame& first,
                    const BodyFrame& second, const Vector3& axis, const SourceLocation& place) {
  ForeignJoint closure;
  closure.place = place;
  closure.is_loop_closure = true;
  Joint& joint = closure.joint;
  joint.name = name;
  for (int n = 2; robot.find_joint(joint.name) >= 0; ++n) joint.name = fmt::format("{}_{}", name, n);
  joint.type = type;
  joint.first = first.body;
  joint.second = second.body;
  joint.point_first = first.pose.p;
  joint.point_second = second.pose.p;
  joint.axis = (first.pose.R * axis).normalized();
  joint.rotation = first.pose.R * second.pose.R.transpose();
  robot.joints.push_back(std::move(closure));
}

std::vector<Pose> zero_configuration_poses(const ForeignModel& robot) {
  std::vector<Pose> poses(robot.bodies.size());
  std::vector<bool> known(robot.bodies.size());
  if (!known.empty()) known[0] = true;
  for (bool growing = true; growing;) {
    growing = false;
    for (const ForeignJoint& one : robot.joints) {
      const auto first = static_cast<std::size_t>(one.joint.first), second = static_cast<std::size_t>(one.joint.second);
      if (!one.is_active || one.is_loop_closure || !known[first] || known[second]) continue;
      poses[second] = poses[first] * joint_zero_pose(one.joint);
      known[second] = growing = true;
    }
  }
  return poses;
}

}  // namespace balance::foreign
