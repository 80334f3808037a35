#include "balance/interface/import/foreign_model.hpp"

#include "balance/foundation/base/unicode_text.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace balance::foreign {

void add_loop_joint(ForeignModel& robot, const std::string& name, JointType type, const BodyFrame& first,
                    const BodyFrame& second, const Vector3& axis, const SourceLocation& place) {
  ForeignJoint foreign_joint;
  foreign_joint.place = place;
  foreign_joint.is_loop_closure = true;
  Joint& joint = foreign_joint.joint;
  joint.name = name;
  for (int n = 2; robot.find_joint(joint.name) >= 0; ++n) joint.name = fmt::format("{}_{}", name, n);
  joint.type = type;
  joint.first = first.body;
  joint.second = second.body;
  joint.point_first = first.pose.p;
  joint.point_second = second.pose.p;
  joint.axis = (first.pose.R * axis).normalized();
  joint.rotation = first.pose.R * second.pose.R.transpose();
  robot.joints.push_back(std::move(foreign_joint));
}

std::vector<Pose> zero_configuration_poses(const ForeignModel& robot) {
  std::vector<Pose> poses(robot.bodies.size());
  std::vector<bool> reached(robot.bodies.size());
  if (!reached.empty()) reached[0] = true;
  for (bool has_grown = true; has_grown;) {
    has_grown = false;
    for (const ForeignJoint& one : robot.joints) {
      const auto first = static_cast<std::size_t>(one.joint.first), second = static_cast<std::size_t>(one.joint.second);
      if (!one.is_active || one.is_loop_closure || !reached[first] || reached[second]) continue;
      poses[second] = poses[first] * joint_zero_pose(one.joint);
      reached[second] = has_grown = true;
    }
  }
  return poses;
}

std::string Finding::text() const {
  const std::string location = place.line > 0 ? fmt::format("{}:{}", place.file, place.line) : place.file;
  const char* kind = level == Severity::warning ? "warning" : "note";
  return escape_for_terminal(
      fmt::format("{}: {}: {}{}{}", location, kind, subject, subject.empty() ? "" : ": ", message));
}

int ForeignModel::find_body(const std::string& body_name) const {
  const auto match = std::find_if(bodies.begin(), bodies.end(),
                                  [&](const ForeignBody& one) { return one.is_active && one.body.name == body_name; });
  return match == bodies.end() ? -1 : static_cast<int>(match - bodies.begin());
}

int ForeignModel::find_joint(const std::string& joint_name) const {
  const auto match = std::find_if(joints.begin(), joints.end(), [&](const ForeignJoint& one) {
    return one.is_active && one.joint.name == joint_name;
  });
  return match == joints.end() ? -1 : static_cast<int>(match - joints.begin());
}

Pose joint_zero_pose(const Joint& joint) {
  return {joint.rotation, joint.point_first - joint.rotation * joint.point_second};
}

Joint reverse_joint(const Joint& joint) {
  Joint reversed = joint;
  std::swap(reversed.first, reversed.second);
  std::swap(reversed.point_first, reversed.point_second);
  // R_fs = Rot(u, q) R₀, so R_sf = Rot(−R₀ᵀu, q) R₀ᵀ; a slide along u is one along −R₀ᵀu seen from the other side
  reversed.rotation = joint.rotation.transpose();
  reversed.axis = -(joint.rotation.transpose() * joint.axis);
  return reversed;
}

}  // namespace balance::foreign
