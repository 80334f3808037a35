#include "balance/import/actuators.hpp"

#include "balance/base/nearest.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>

namespace balance::foreign {

namespace {

bool moves(const RobotJoint& one) { return one.kept && freedom(one.joint.type) > 0; }

void drive_named(Robot& robot, const std::vector<std::string>& wanted) {
  for (RobotJoint& one : robot.joints) one.driven = false;
  std::vector<std::string> names;
  for (const RobotJoint& one : robot.joints)
    if (moves(one)) names.push_back(one.joint.name);
  for (const std::string& name : wanted) {
    const int found = robot.find_joint(name);
    if (found < 0 || !moves(robot.joints[static_cast<std::size_t>(found)]))
      throw SpecError({.place = {.file = "--actuate"},
                       .message = fmt::format("expected a joint that moves ({}), found {}{}", one_of(names),
                                              in_quotes(name), nearest_hint(name, names))});
    robot.joints[static_cast<std::size_t>(found)].driven = true;
  }
}

bool has_loops(const Robot& robot) {
  const auto kept = std::count_if(robot.bodies.begin(), robot.bodies.end(), [](const RobotBody& b) { return b.kept; });
  const auto joints =
      std::count_if(robot.joints.begin(), robot.joints.end(), [](const RobotJoint& j) { return j.kept; });
  return joints > kept - 1;
}

}  // namespace

void choose_actuators(Robot& robot, const std::vector<std::string>& wanted) {
  if (!wanted.empty()) return drive_named(robot, wanted);
  if (robot.knows_motors) return;
  if (has_loops(robot)) {
    robot.findings.push_back({Level::warning,
                              {.file = robot.file},
                              "no-motors",
                              "",
                              "there are loops, and nothing says which joints have motors: --actuate NAME,NAME does"});
    return;
  }
  std::set<int> followers;
  for (const RobotCoupling& coupling : robot.couplings) followers.insert(coupling.follower);
  for (int j = 0; j < static_cast<int>(robot.joints.size()); ++j) {
    RobotJoint& one = robot.joints[static_cast<std::size_t>(j)];
    one.driven = moves(one) && followers.count(j) == 0;
  }
}

}  // namespace balance::foreign
