#include "balance/interface/import/foreign_model.hpp"

#include "balance/foundation/base/unicode_text.hpp"

#include <fmt/format.h>

#include <algorithm>

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

std::string Finding::text() const {
  const std::string where = place.line > 0 ? fmt::format("{}:{}", place.file, place.line) : place.file;
  const char* kind = level == Severity::warning ? "warning" : "note";
  return escape_for_terminal(fmt::format("{}: {}: {}{}{}", where, kind, subject, subject.empty() ? "" : ": ", message));
}

int ForeignModel::find_body(const std::string& wanted) const {
  const auto found = std::find_if(bodies.begin(), bodies.end(),
                                  [&](const ForeignBody& one) { return one.is_active && one.body.name == wanted; });
  return found == bodies.end() ? -1 : static_cast<int>(found - bodies.begin());
}

int ForeignModel::find_joint(const std::string& wanted) const {
  const auto found = std::find_if(joints.begin(), joints.end(),
                                  [&](const ForeignJoint& one) { return one.is_active && one.joint.name == wanted; });
  return found == joints.end() ? -1 : static_cast<int>(found - joints.begin());
}

Pose joint_zero_pose(const Joint& joint) {
  return {joint.rotation, joint.point_first - joint.rotation * joint.point_second};
}

Joint reverse_joint(const Joint& joint) {
  Joint other = joint;
  std::swap(other.first, other.second);
  std::swap(other.point_first, other.point_second);
  // R_fs = Rot(u, q) R₀, so R_sf = Rot(−R₀ᵀu, q) R₀ᵀ; a slide along u is one along −R₀ᵀu seen from the other side
  other.rotation = joint.rotation.transpose();
  other.axis = -(joint.rotation.transpose() * joint.axis);
  return other;
}

}  // namespace balance::foreign
