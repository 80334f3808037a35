#include "balance/import/robot.hpp"

#include "balance/base/plain_text.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace balance::foreign {

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
