#include "balance/base/nearest.hpp"
#include "balance/base/rotation.hpp"
#include "balance/import/simplify.hpp"

#include <fmt/format.h>

namespace balance::foreign {

namespace {

ForeignBody& at(ForeignModel& robot, int body) { return robot.bodies[static_cast<std::size_t>(body)]; }

/// Mass, centre of mass and inertia of two bodies that are one; the second is at `pose` in the first.
void add_mass(Body& body, const Body& other, const Pose& pose) {
  const double mass = body.mass + other.mass;
  const Vector3 place = pose.p + pose.R * other.com;
  const Matrix3 turned = pose.R * other.inertia * pose.R.transpose();
  if (!(mass > 0)) {
    body.inertia += turned;
    return;
  }
  if (body.mass == 0 && body.inertia.isZero(0)) {
    body.mass = mass;
    body.com = place;
    body.inertia = 0.5 * (turned + turned.transpose());
    return;
  }
  const Vector3 com = (body.mass * body.com + other.mass * place) / mass;
  const auto about = [](double m, const Vector3& r) { return Matrix3(-m * skew(r) * skew(r)); };
  const Matrix3 sum = body.inertia + about(body.mass, body.com - com) + turned + about(other.mass, place - com);
  body.mass = mass;
  body.com = com;
  body.inertia = 0.5 * (sum + sum.transpose());
}

void move_joint(ForeignJoint& one, int from, int to, const Pose& pose) {
  Joint& joint = one.joint;
  if (joint.first == from) {
    joint.first = to;
    joint.point_first = pose.p + pose.R * joint.point_first;
    joint.axis = pose.R * joint.axis;
    joint.axis2 = pose.R * joint.axis2;
    joint.rotation = pose.R * joint.rotation;
    if (!pose.R.isIdentity(0)) one.rpy.reset();
  }
  if (joint.second == from) {
    joint.second = to;
    joint.point_second = pose.p + pose.R * joint.point_second;
    joint.rotation = joint.rotation * pose.R.transpose();
    if (!pose.R.isIdentity(0)) one.rpy.reset();
  }
}

/// Everything of `from`, which stands at `pose` in `to`, becomes part of `to`.
void merge(ForeignModel& robot, int from, int to, const Pose& pose) {
  ForeignBody &gone = at(robot, from), &stays = at(robot, to);
  if (to != 0) add_mass(stays.body, gone.body, pose);
  stays.merged_bodies.push_back({from, pose});
  for (const MergedBody& one : gone.merged_bodies) stays.merged_bodies.push_back({one.body, pose * one.pose});
  stays.has_inertial = stays.has_inertial || gone.has_inertial;
  stays.has_geometry = stays.has_geometry || gone.has_geometry;
  stays.body.points.push_back({gone.body.name, pose.p});
  for (const NamedPoint& point : gone.body.points)
    stays.body.points.push_back({point.name, pose.p + pose.R * point.position});
  gone.body.points.clear();
  gone.is_active = false;
  for (ForeignJoint& joint : robot.joints) move_joint(joint, from, to, pose);
  const auto move_end = [&](BodyId& body, Vector3& point) {
    if (body != from) return;
    body = to;
    point = pose.p + pose.R * point;
  };
  for (Spring& spring : robot.springs) {
    move_end(spring.first, spring.point_first);
    move_end(spring.second, spring.point_second);
  }
}

/// A fixed joint between places of one body says nothing, or what cannot be.
void check_consistent(const ForeignJoint& one) {
  const Pose pose = joint_zero_pose(one.joint);
  const double scale = std::max(1.0, one.joint.point_first.norm());
  if (pose.p.norm() <= 1e-6 * scale && (pose.R - Matrix3::Identity()).norm() <= 1e-6) return;
  throw SpecError(
      {.place = one.place,
       .message = fmt::format("joint {}: fixed joints contradict each other: what it joins is fixed elsewhere, "
                              "{:.3g} m away",
                              quote_for_message(one.joint.name), pose.p.norm())});
}

}  // namespace

void merge_fixed_bodies(ForeignModel& robot) {
  std::vector<std::string> to_ground, merged;
  for (std::size_t j = 0; j < robot.joints.size(); ++j) {
    ForeignJoint& one = robot.joints[j];
    if (!one.is_active || one.joint.type != JointType::fixed) continue;
    one.is_active = false;
    const int first = one.joint.first, second = one.joint.second;
    if (first == second) {
      check_consistent(one);
      continue;
    }
    const Pose pose = joint_zero_pose(one.joint);
    const bool grounded = first == 0 || second == 0;
    (grounded ? to_ground : merged).push_back(at(robot, second == 0 ? first : second).body.name);
    if (second == 0)
      merge(robot, first, second, pose.inverse());
    else
      merge(robot, second, first, pose);
  }
  const auto tell = [&](const std::vector<std::string>& names, const char* into) {
    if (!names.empty())
      robot.findings.push_back({Severity::note,
                                {.file = robot.file},
                                "merged",
                                "",
                                fmt::format("merged into {}: {}", into, join_with_conjunction(names, "and"))});
  };
  tell(merged, "what they are fixed to");
  tell(to_ground, "the ground");
}

}  // namespace balance::foreign
