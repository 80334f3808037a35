#include "balance/import/prepare.hpp"

#include "balance/base/nearest.hpp"
#include "balance/import/actuators.hpp"
#include "balance/import/lint.hpp"
#include "balance/import/simplify.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace balance::foreign {

namespace {

void check_something_moves(const ForeignModel& robot) {
  const auto kept = [](const auto& one) { return one.is_active; };
  if (std::count_if(robot.bodies.begin(), robot.bodies.end(), kept) > 1 &&
      std::any_of(robot.joints.begin(), robot.joints.end(), kept))
    return;
  throw SpecError(
      {.place = {robot.file, 1, 1, ""}, .message = "expected something that moves: all of it is fixed to the ground"});
}

/// What floats is held, if that was asked for, or refused.
void fix_floating_joints(ForeignModel& robot, bool hold) {
  for (const ForeignJoint& one : robot.joints) {
    if (!one.is_active || !one.is_floating) continue;
    const std::string subject = fmt::format("joint {}", quote_for_message(one.joint.name));
    if (!hold || one.joint.first != 0)
      throw SpecError({.place = one.place,
                       .message = fmt::format("{}: a body that floats has no joint in a spec{}", subject,
                                              one.joint.first == 0 ? "; --base fixed holds it where it is" : "")});
    robot.findings.push_back({Severity::note, one.place, "held", subject, "floats in the file and is held still"});
  }
}

/// Closures may join what is joined already, and bodies of the ground to each other.
void remove_internal_joints(ForeignModel& robot) {
  for (ForeignJoint& one : robot.joints) {
    if (!one.is_active || one.joint.first != one.joint.second) continue;
    one.is_active = false;
    robot.findings.push_back({Severity::warning, one.place, "within",
                              fmt::format("joint {}", quote_for_message(one.joint.name)),
                              "joins two parts of one body: left out"});
  }
  std::erase_if(robot.couplings, [&](const ForeignCoupling& one) {
    const auto gone = [&](int j) { return !robot.joints[static_cast<std::size_t>(j)].is_active; };
    return gone(one.follower) || gone(one.leader);
  });
  std::erase_if(robot.springs, [](const Spring& one) { return one.first == one.second; });
}

/// A joint follows one other at most, and none follows itself. What follows two is led by one of them the other way round.
void orient_couplings(ForeignModel& robot) {
  std::vector<int> leaders(robot.joints.size(), -1);
  const auto at = [](int joint) { return static_cast<std::size_t>(joint); };
  const auto leads = [&](int joint, int other) {  // up the chain of leaders
    while (other >= 0 && other != joint) other = leaders[at(other)];
    return other == joint;
  };
  for (ForeignCoupling& one : robot.couplings) {
    if (leaders[at(one.follower)] >= 0 && leaders[at(one.leader)] < 0) {
      std::swap(one.follower, one.leader);
      one.offset = -one.offset / one.ratio;
      one.ratio = 1 / one.ratio;
    }
    if (leaders[at(one.follower)] >= 0 || leads(one.follower, one.leader))
      throw SpecError(
          {.place = one.place,
           .message = fmt::format("expected a joint that follows one other, found {}, which is coupled twice",
                                  quote_for_message(robot.joints[at(one.follower)].joint.name))});
    leaders[at(one.follower)] = one.leader;
  }
}

/// Bodies that no chain of joints holds.
void check_bodies_connected(const ForeignModel& robot) {
  std::vector<bool> held(robot.bodies.size());
  if (!held.empty()) held[0] = true;
  for (bool growing = true; growing;) {
    growing = false;
    for (const ForeignJoint& one : robot.joints) {
      const auto first = static_cast<std::size_t>(one.joint.first), second = static_cast<std::size_t>(one.joint.second);
      if (!one.is_active || held[first] == held[second]) continue;
      held[first] = held[second] = growing = true;
    }
  }
  for (std::size_t b = 1; b < robot.bodies.size(); ++b)
    if (robot.bodies[b].is_active && !held[b])
      throw SpecError(
          {.place = robot.bodies[b].place,
           .message = fmt::format("body {}: no chain of joints holds it: a body that floats has no joint in a spec",
                                  quote_for_message(robot.bodies[b].body.name))});
}

}  // namespace

void simplify_model(ForeignModel& robot, const ImportOptions& options) {
  fix_floating_joints(robot, options.fixed_base);
  orient_couplings(robot);
  lint_masses(robot);
  choose_actuators(robot, options.actuate);
  merge_fixed_bodies(robot);
  remove_internal_joints(robot);
  remove_massless_leaves(robot);
  merge_massless_bodies(robot);
  check_something_moves(robot);
  check_bodies_connected(robot);
  std::stable_sort(robot.findings.begin(), robot.findings.end(),
                   [](const Finding& a, const Finding& b) { return a.place.line < b.place.line; });
}

}  // namespace balance::foreign
