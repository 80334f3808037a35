#include "balance/import/actuators.hpp"

#include "balance/base/nearest.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

namespace balance::foreign {

namespace {

bool is_movable(const ForeignJoint& one) { return one.is_active && joint_degrees_of_freedom(one.joint.type) > 0; }

void actuate_named_joints(ForeignModel& robot, const std::vector<std::string>& wanted) {
  for (ForeignJoint& one : robot.joints) one.is_actuated = false;
  std::vector<std::string> names;
  for (const ForeignJoint& one : robot.joints)
    if (is_movable(one)) names.push_back(one.joint.name);
  for (const std::string& name : wanted) {
    const int found = robot.find_joint(name);
    if (found < 0 || !is_movable(robot.joints[static_cast<std::size_t>(found)]))
      throw SpecError({.place = {.file = "--actuate"},
                       .message = fmt::format("expected a joint that moves ({}), found {}{}", join_alternatives(names),
                                              quote_for_message(name), append_nearest_name(name, names))});
    robot.joints[static_cast<std::size_t>(found)].is_actuated = true;
  }
}

/// What a coupling makes move together has one motor, that of the joint which the others follow: two would be one too many.
void actuate_couplings_once(ForeignModel& robot) {
  std::vector<int> leader(robot.joints.size(), -1);
  for (const ForeignCoupling& one : robot.couplings) leader[static_cast<std::size_t>(one.follower)] = one.leader;
  const auto first_of = [&](int joint) {
    while (leader[static_cast<std::size_t>(joint)] >= 0) joint = leader[static_cast<std::size_t>(joint)];
    return joint;
  };
  std::map<int, std::vector<int>> driven;  // by the joint that all of them follow
  for (int j = 0; j < static_cast<int>(robot.joints.size()); ++j)
    if (is_movable(robot.joints[static_cast<std::size_t>(j)]) && robot.joints[static_cast<std::size_t>(j)].is_actuated)
      driven[first_of(j)].push_back(j);
  for (const auto& [first, joints] : driven) {
    if (joints.size() < 2) continue;
    const ForeignJoint& kept = robot.joints[static_cast<std::size_t>(first)];
    for (const int j : joints) {
      ForeignJoint& one = robot.joints[static_cast<std::size_t>(j)];
      if (j == first) continue;
      one.is_actuated = false;
      robot.findings.push_back(
          {Severity::note, one.place, "one-motor", fmt::format("joint {}", quote_for_message(one.joint.name)),
           fmt::format("is coupled to {}: one motor, there, moves both", quote_for_message(kept.joint.name))});
    }
    robot.joints[static_cast<std::size_t>(first)].is_actuated = true;
  }
}

bool has_loops(const ForeignModel& robot) {
  const auto kept =
      std::count_if(robot.bodies.begin(), robot.bodies.end(), [](const ForeignBody& b) { return b.is_active; });
  const auto joints =
      std::count_if(robot.joints.begin(), robot.joints.end(), [](const ForeignJoint& j) { return j.is_active; });
  return joints > kept - 1;
}

}  // namespace

void choose_actuators(ForeignModel& robot, const std::vector<std::string>& wanted) {
  if (!wanted.empty()) actuate_named_joints(robot, wanted);
  if (!wanted.empty() || robot.declares_actuators) return actuate_couplings_once(robot);
  if (has_loops(robot)) {
    robot.findings.push_back({Severity::warning,
                              {.file = robot.file},
                              "no-motors",
                              "",
                              "there are loops, and nothing says which joints have motors: --actuate NAME,NAME does"});
    return;
  }
  std::set<int> followers;
  for (const ForeignCoupling& coupling : robot.couplings) followers.insert(coupling.follower);
  for (int j = 0; j < static_cast<int>(robot.joints.size()); ++j) {
    ForeignJoint& one = robot.joints[static_cast<std::size_t>(j)];
    one.is_actuated = is_movable(one) && followers.count(j) == 0;
  }
}

}  // namespace balance::foreign
