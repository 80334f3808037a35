#include "balance/import/actuators.hpp"

#include "balance/base/nearest.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
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

/// What a coupling makes move together has one motor, that of the joint which the others follow: two would be one too many.
void drive_coupled_once(Robot& robot) {
  std::vector<int> leader(robot.joints.size(), -1);
  for (const RobotCoupling& one : robot.couplings) leader[static_cast<std::size_t>(one.follower)] = one.leader;
  const auto first_of = [&](int joint) {
    while (leader[static_cast<std::size_t>(joint)] >= 0) joint = leader[static_cast<std::size_t>(joint)];
    return joint;
  };
  std::map<int, std::vector<int>> driven;  // by the joint that all of them follow
  for (int j = 0; j < static_cast<int>(robot.joints.size()); ++j)
    if (moves(robot.joints[static_cast<std::size_t>(j)]) && robot.joints[static_cast<std::size_t>(j)].driven)
      driven[first_of(j)].push_back(j);
  for (const auto& [first, joints] : driven) {
    if (joints.size() < 2) continue;
    const RobotJoint& kept = robot.joints[static_cast<std::size_t>(first)];
    for (const int j : joints) {
      RobotJoint& one = robot.joints[static_cast<std::size_t>(j)];
      if (j == first) continue;
      one.driven = false;
      robot.findings.push_back(
          {Level::note, one.place, "one-motor", fmt::format("joint {}", in_quotes(one.joint.name)),
           fmt::format("is coupled to {}: one motor, there, moves both", in_quotes(kept.joint.name))});
    }
    robot.joints[static_cast<std::size_t>(first)].driven = true;
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
  if (!wanted.empty()) drive_named(robot, wanted);
  if (!wanted.empty() || robot.knows_motors) return drive_coupled_once(robot);
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
