#include "balance/interface/import/axis_chain.hpp"

#include "balance/foundation/base/elementary.hpp"
#include "balance/foundation/base/spelling.hpp"

#include <fmt/format.h>

#include <cmath>

namespace balance::foreign {

std::vector<AxisLink> list_axis_links(const RobotTree& tree) {
  std::vector<AxisLink> all;
  std::vector<int> index;  // of the last link of every body
  for (const RobotLink& link : tree.links) {
    int parent = link.parent == ground_link ? ground_link : index[static_cast<std::size_t>(link.parent)];
    for (std::size_t k = 0; k + 1 < link.joints.size(); ++k) {
      const RobotJoint& joint = link.joints[k];
      all.push_back({fmt::format("{} before {}", link.name, link.joints[k + 1].name),
                     joint.name,
                     parent,
                     {link.pose.R, joint.anchor},
                     &joint,
                     nullptr});
      parent = static_cast<int>(all.size()) - 1;
    }
    const RobotJoint* joint = link.joints.empty() ? nullptr : &link.joints.back();
    all.push_back({link.name,
                   joint != nullptr ? joint->name : link.name + " fixed",
                   parent,
                   {link.pose.R, joint != nullptr ? joint->anchor : link.pose.p},
                   joint,
                   &link});
    index.push_back(static_cast<int>(all.size()) - 1);
  }
  return all;
}

Vector3 rpy_of(const Matrix3& R) {
  const double cosine = std::hypot(R(0, 0), R(1, 0));
  const double pitch = elementary::atan2(-R(2, 0), cosine);
  constexpr double gimbal_lock_threshold = 1e-9;
  if (cosine < gimbal_lock_threshold)  // only roll ∓ yaw matters
    return {elementary::atan2(-R(1, 2), R(1, 1)), pitch, 0};
  return {elementary::atan2(R(2, 1), R(2, 2)), pitch, elementary::atan2(R(1, 0), R(0, 0))};
}

std::vector<std::string> describe_closures(const RobotTree& tree) {
  std::vector<std::string> lines;
  const auto name = [&](int link) {
    return link == ground_link ? std::string("the ground")
                               : quote_for_message(tree.links[static_cast<std::size_t>(link)].name);
  };
  for (const RobotClosure& closure : tree.closures)
    lines.push_back(fmt::format("joint {} closes a loop: {} {} {}", quote_for_message(closure.name),
                                name(closure.first), closure.is_weld ? "is fixed to" : "meets", name(closure.second)));
  return lines;
}

Pose relative_pose(const std::vector<AxisLink>& links, const AxisLink& link) {
  const Pose parent = link.parent == ground_link ? Pose{} : links[static_cast<std::size_t>(link.parent)].pose;
  return parent.inverse() * link.pose;
}

const RobotMotor* find_motor(const RobotTree& tree, const std::string& joint) {
  for (const RobotMotor& motor : tree.motors)
    if (motor.joint == joint) return &motor;
  return nullptr;
}

void report_split_couplings(const RobotTree& tree, std::vector<std::string>& missing) {
  for (const RobotCoupling& coupling : tree.couplings)
    if (coupling.leaders.size() != 1)
      missing.push_back(
          fmt::format("the coupling of {}, which follows several joints", quote_for_message(coupling.joint)));
}

void report_point_springs(const RobotTree& tree, std::vector<std::string>& missing) {
  for (const RobotSpring& spring : tree.springs)
    missing.push_back(fmt::format("{} {} between points", spring.stiffness == 0 ? "damper" : "spring",
                                  quote_for_message(spring.name)));
}

}  // namespace balance::foreign
