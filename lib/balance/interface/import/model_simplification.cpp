#include "balance/interface/import/model_simplification.hpp"

#include "balance/foundation/base/elementary.hpp"
#include "balance/foundation/base/rotation.hpp"
#include "balance/foundation/base/spelling.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>
#include <set>

namespace balance::foreign {

namespace {

bool is_movable(const ForeignJoint& one) { return one.is_active && joint_degrees_of_freedom(one.joint.type) > 0; }

void actuate_named_joints(ForeignModel& robot, const std::vector<std::string>& actuated_names) {
  for (ForeignJoint& one : robot.joints) one.is_actuated = false;
  std::vector<std::string> names;
  for (const ForeignJoint& one : robot.joints)
    if (is_movable(one)) names.push_back(one.joint.name);
  for (const std::string& name : actuated_names) {
    const int joint = robot.find_joint(name);
    if (joint < 0 || !is_movable(robot.joints[static_cast<std::size_t>(joint)]))
      throw SpecError({.place = {.file = "--actuate"},
                       .message = fmt::format("expected a joint that moves ({}), found {}{}", join_alternatives(names),
                                              quote_for_message(name), append_nearest_name(name, names))});
    robot.joints[static_cast<std::size_t>(joint)].is_actuated = true;
  }
}

/// Leaves one motor to joints that are coupled to each other, at the joint that the others
/// follow: a second one is redundant.
void actuate_couplings_once(ForeignModel& robot) {
  std::vector<int> leader(robot.joints.size(), -1);
  for (const ForeignCoupling& one : robot.couplings) leader[static_cast<std::size_t>(one.follower)] = one.leader;
  const auto find_root_leader = [&](int joint) {
    while (leader[static_cast<std::size_t>(joint)] >= 0) joint = leader[static_cast<std::size_t>(joint)];
    return joint;
  };
  std::map<int, std::vector<int>> actuated_by_leader;  // by the joint that all of them follow
  for (int j = 0; j < static_cast<int>(robot.joints.size()); ++j)
    if (is_movable(robot.joints[static_cast<std::size_t>(j)]) && robot.joints[static_cast<std::size_t>(j)].is_actuated)
      actuated_by_leader[find_root_leader(j)].push_back(j);
  for (const auto& [root_leader, joints] : actuated_by_leader) {
    if (joints.size() < 2) continue;
    const ForeignJoint& leader_joint = robot.joints[static_cast<std::size_t>(root_leader)];
    for (const int j : joints) {
      ForeignJoint& one = robot.joints[static_cast<std::size_t>(j)];
      if (j == root_leader) continue;
      one.is_actuated = false;
      robot.findings.push_back(
          {Severity::note, one.place, "one-motor", fmt::format("joint {}", quote_for_message(one.joint.name)),
           fmt::format("is coupled to {}: one motor, there, moves both", quote_for_message(leader_joint.joint.name))});
    }
    robot.joints[static_cast<std::size_t>(root_leader)].is_actuated = true;
  }
}

bool has_loops(const ForeignModel& robot) {
  const auto body_count =
      std::count_if(robot.bodies.begin(), robot.bodies.end(), [](const ForeignBody& b) { return b.is_active; });
  const auto joint_count =
      std::count_if(robot.joints.begin(), robot.joints.end(), [](const ForeignJoint& j) { return j.is_active; });
  return joint_count > body_count - 1;
}

}  // namespace

void choose_actuators(ForeignModel& robot, const std::vector<std::string>& actuated_names) {
  if (!actuated_names.empty()) actuate_named_joints(robot, actuated_names);
  if (!actuated_names.empty() || robot.declares_actuators) return actuate_couplings_once(robot);
  if (has_loops(robot)) {
    robot.findings.push_back({Severity::warning,
                              {.file = robot.file},
                              "no-motors",
                              "",
                              "there are loops, and no motors are specified: use --actuate NAME,NAME"});
    return;
  }
  std::set<int> followers;
  for (const ForeignCoupling& coupling : robot.couplings) followers.insert(coupling.follower);
  for (int j = 0; j < static_cast<int>(robot.joints.size()); ++j) {
    ForeignJoint& one = robot.joints[static_cast<std::size_t>(j)];
    one.is_actuated = is_movable(one) && followers.count(j) == 0;
  }
}

namespace {

constexpr double line_coincidence_tolerance =
    1e-9;  // for directions and, in metres, positions; covers the rounding of written digits

bool is_massless(const ForeignBody& one) { return one.body.mass == 0 && one.body.inertia.isZero(0); }

class MasslessBodyMerger {
 public:
  explicit MasslessBodyMerger(ForeignModel& robot) : robot_(robot) {
    for (const ForeignCoupling& coupling : robot.couplings)
      coupled_joints_.insert({coupling.follower, coupling.leader});
    for (const Spring& spring : robot.springs) spring_bodies_.insert({spring.first, spring.second});
  }

  void run() {
    for (bool changed = true; changed;) {
      changed = false;
      for (int b = 1; b < static_cast<int>(robot_.bodies.size()); ++b) changed = merge_to_spherical(b) || changed;
    }
    for (bool changed = true; changed;) {
      changed = false;
      for (int b = 1; b < static_cast<int>(robot_.bodies.size()); ++b) changed = merge_joint_pair(b) || changed;
    }
  }

 private:
  ForeignJoint& joint(int j) { return robot_.joints[static_cast<std::size_t>(j)]; }

  bool is_passive(int j) {
    const ForeignJoint& one = joint(j);
    return coupled_joints_.count(j) == 0 && !one.is_actuated && one.viscous == 0 && one.coulomb == 0 &&
           one.stiffness == 0;
  }

  /// The two joints of a massless body to which nothing else is attached; std::nullopt if there
  /// are others or one is needed.
  std::optional<std::pair<int, int>> joints_of(int b) {
    const ForeignBody& one = robot_.bodies[static_cast<std::size_t>(b)];
    if (!one.is_active || !is_massless(one) || spring_bodies_.count(b) > 0) return {};
    std::vector<int> joints;
    for (int j = 0; j < static_cast<int>(robot_.joints.size()); ++j)
      if (joint(j).is_active && (joint(j).joint.first == b || joint(j).joint.second == b)) joints.push_back(j);
    if (joints.size() != 2 || !is_passive(joints[0]) || !is_passive(joints[1])) return {};
    return std::pair(joints[0], joints[1]);
  }

  /// The joint oriented such that the body is its second, or its first.
  static Joint orient_towards(const Joint& joint, int body) {
    return joint.second == body ? joint : reverse_joint(joint);
  }
  static Joint orient_from(const Joint& joint, int body) { return joint.first == body ? joint : reverse_joint(joint); }

  static bool is_revolute(const Joint& joint) { return joint.type == JointType::revolute; }

  /// Point of a revolute joint's line nearest to a given point, all in the axes of the body in which the line is given.
  static Vector3 nearest_point_on_line(const Vector3& on_line, const Vector3& direction, const Vector3& point) {
    return on_line + direction * direction.dot(point - on_line);
  }

  void replace(int body, int kept_joint, int removed_joint, Joint combined) {
    combined.name = joint(kept_joint).joint.name;
    joint(kept_joint).joint = combined;
    joint(kept_joint).rpy.reset();
    joint(kept_joint).limits = {};
    joint(kept_joint).note = fmt::format("{} and {} with nothing between them", joint(kept_joint).joint.name,
                                         joint(removed_joint).joint.name);
    joint(removed_joint).is_active = false;
    robot_.bodies[static_cast<std::size_t>(body)].is_active = false;
    const char* type = combined.type == JointType::revolute    ? "revolute"
                       : combined.type == JointType::universal ? "universal"
                                                               : "spherical";
    robot_.findings.push_back({Severity::note, joint(kept_joint).place, "collapsed",
                               fmt::format("joint {}", quote_for_message(joint(kept_joint).joint.name)),
                               fmt::format("with {} a single {} joint: there is no mass between them",
                                           quote_for_message(joint(removed_joint).joint.name), type)});
  }

  /// a: P → M, b: M → Q, both revolute, or one of them spherical.
  bool merge_joint_pair(int m) {
    const auto pair = joints_of(m);
    if (!pair) return false;
    const Joint &raw_a = joint(pair->first).joint, &raw_b = joint(pair->second).joint;
    const auto is_spherical = [](const Joint& one) { return one.type == JointType::spherical; };
    if (is_spherical(raw_a) != is_spherical(raw_b) && (is_revolute(raw_a) || is_revolute(raw_b)))
      return merge_next_to_spherical(m, pair->first, pair->second);
    if (!is_revolute(raw_a) || !is_revolute(raw_b)) return false;
    const Joint a = orient_towards(raw_a, m), b = orient_from(raw_b, m);
    if (a.first == b.second) return false;
    const auto coaxial = merge_coaxial(a, b);
    if (coaxial) return replace(m, pair->first, pair->second, *coaxial), true;
    const auto universal = merge_to_universal(a, b);
    if (universal) return replace(m, pair->first, pair->second, *universal), true;
    return false;
  }

  static Joint compose_joints(const Joint& a, const Joint& b) {
    Joint combined = a;
    combined.second = b.second;
    combined.rotation = a.rotation * b.rotation;
    combined.point_second = b.point_second;
    return combined;
  }

  static std::optional<Joint> merge_coaxial(const Joint& a, const Joint& b) {
    const Vector3 u = a.rotation.transpose() * a.axis;  // in M
    const Vector3 between = b.point_first - a.point_second;
    if (u.cross(b.axis).norm() > line_coincidence_tolerance || u.cross(between).norm() > line_coincidence_tolerance)
      return {};
    Joint combined = compose_joints(a, b);
    combined.point_first = a.point_first + a.rotation * between;
    return combined;
  }

  /// Intersection of two lines in M; std::nullopt if they do not meet.
  static std::optional<Vector3> intersect_lines(const Vector3& p, const Vector3& u, const Vector3& q,
                                                const Vector3& v) {
    const double sin_squared = 1 - elementary::pow(u.dot(v), 2);
    if (sin_squared < 1e-6) return {};
    const Vector3 d = q - p;
    const double s = (d.dot(u) - d.dot(v) * u.dot(v)) / sin_squared;
    const Vector3 intersection = p + s * u;
    if ((nearest_point_on_line(q, v, intersection) - intersection).norm() > line_coincidence_tolerance) return {};
    return intersection;
  }

  static std::optional<Joint> merge_to_universal(const Joint& a, const Joint& b) {
    const Vector3 u = a.rotation.transpose() * a.axis;
    if (std::abs(u.dot(b.axis)) > line_coincidence_tolerance) return {};
    const auto intersection = intersect_lines(a.point_second, u, b.point_first, b.axis);
    if (!intersection) return {};
    Joint combined = compose_joints(a, b);
    combined.type = JointType::universal;
    combined.axis2 = a.rotation * b.axis;
    combined.axis2 = (combined.axis2 - combined.axis2.dot(a.axis) * a.axis).normalized();
    // both points lie on their joint's line, which is fixed in its own body
    combined.point_first = a.point_first + a.rotation * (*intersection - a.point_second);
    combined.point_second = b.point_second + b.rotation.transpose() * (*intersection - b.point_first);
    return combined;
  }

  bool merge_next_to_spherical(int m, int j, int k) {
    if (is_revolute(joint(k).joint)) std::swap(j, k);  // j is revolute, k is spherical
    const Joint a = orient_towards(joint(j).joint, m), spherical = orient_from(joint(k).joint, m);
    const Vector3 u = a.rotation.transpose() * a.axis;
    if (a.first == spherical.second ||
        u.cross(spherical.point_first - a.point_second).norm() > line_coincidence_tolerance)
      return false;
    Joint combined = compose_joints(a, spherical);
    combined.type = JointType::spherical;
    combined.point_first = a.point_first + a.rotation * (spherical.point_first - a.point_second);
    replace(m, k, j, combined);
    return true;
  }

  /// a: P → M, b: M → N, c: N → Q, all revolute, M and N massless, all lines through one point.
  bool merge_to_spherical(int m) {
    const auto pair = joints_of(m);
    if (!pair || !is_revolute(joint(pair->first).joint) || !is_revolute(joint(pair->second).joint)) return false;
    for (const auto& [ja, jb] : {std::pair(pair->first, pair->second), std::pair(pair->second, pair->first)}) {
      const Joint a = orient_towards(joint(ja).joint, m), b = orient_from(joint(jb).joint, m);
      const int n = b.second;
      const auto next = joints_of(n);
      if (!next || n == a.first) continue;
      const int jc = next->first == jb ? next->second : next->first;
      if (!is_revolute(joint(jc).joint)) continue;
      const Joint c = orient_from(joint(jc).joint, n);
      if (c.second == a.first || c.second == m) continue;
      const auto ab = intersect_lines(a.point_second, a.rotation.transpose() * a.axis, b.point_first, b.axis);
      const auto bc = intersect_lines(b.point_second, b.rotation.transpose() * b.axis, c.point_first, c.axis);
      if (!ab || !bc) continue;
      const Vector3 ab_in_n = b.point_second + b.rotation.transpose() * (*ab - b.point_first);
      if ((ab_in_n - *bc).norm() > line_coincidence_tolerance) continue;
      Joint combined = compose_joints(compose_joints(a, b), c);
      combined.type = JointType::spherical;
      combined.point_first = a.point_first + a.rotation * (*ab - a.point_second);
      combined.point_second = c.point_second + c.rotation.transpose() * (*bc - c.point_first);
      replace(m, ja, jb, combined);
      joint(jc).is_active = false;
      robot_.bodies[static_cast<std::size_t>(n)].is_active = false;
      return true;
    }
    return false;
  }

  ForeignModel& robot_;
  std::set<int> coupled_joints_;  ///< joints in couplings
  std::set<int> spring_bodies_;   ///< bodies with springs
};

}  // namespace

void merge_massless_bodies(ForeignModel& robot) { MasslessBodyMerger(robot).run(); }

namespace {

/// Removes massless ends of chains, one after the other.
class MasslessLeafRemover {
 public:
  explicit MasslessLeafRemover(ForeignModel& robot)
      : robot_(robot), body_joints_(robot.bodies.size()), is_joint_needed_(robot.joints.size()) {
    for (std::size_t j = 0; j < robot.joints.size(); ++j) {
      const ForeignJoint& one = robot.joints[j];
      is_joint_needed_[j] = one.is_actuated;
      if (one.is_active)
        for (const int body : {one.joint.first, one.joint.second})
          body_joints_[at(body)].push_back(static_cast<int>(j));
    }
    for (const ForeignCoupling& coupling : robot.couplings) is_joint_needed_[at(coupling.leader)] = true;
    for (const Spring& spring : robot.springs) spring_bodies_.insert({spring.first, spring.second});
  }

  void run() {
    for (int b = 1; b < static_cast<int>(robot_.bodies.size()); ++b)
      for (int leaf = b; leaf > 0;) leaf = remove_leaf(leaf);
    std::erase_if(robot_.couplings,
                  [&](const ForeignCoupling& one) { return !robot_.joints[at(one.follower)].is_active; });
  }

 private:
  static std::size_t at(int index) { return static_cast<std::size_t>(index); }

  /// @return the body at the other end of its joint, which may be an end now; 0 if the body stays
  int remove_leaf(int b) {
    ForeignBody& leaf = robot_.bodies[at(b)];
    if (!leaf.is_active || !is_massless(leaf) || spring_bodies_.count(b) > 0 || body_joints_[at(b)].size() != 1)
      return 0;
    const int j = body_joints_[at(b)].front();
    ForeignJoint& joint = robot_.joints[at(j)];
    if (is_joint_needed_[at(j)]) return 0;
    leaf.is_active = joint.is_active = false;
    robot_.findings.push_back({Severity::warning, leaf.place, "empty-end",
                               fmt::format("link {}", quote_for_message(leaf.body.name)),
                               fmt::format("has no mass and carries nothing: left out with its joint {}",
                                           quote_for_message(joint.joint.name))});
    const int other = joint.joint.first == b ? joint.joint.second : joint.joint.first;
    std::erase(body_joints_[at(other)], j);
    return other;
  }

  ForeignModel& robot_;
  std::vector<std::vector<int>> body_joints_;  ///< joints of every body
  std::vector<bool> is_joint_needed_;          ///< joints whose coordinate is needed
  std::set<int> spring_bodies_;                ///< bodies with springs
};

}  // namespace

void remove_massless_leaves(ForeignModel& robot) { MasslessLeafRemover(robot).run(); }

namespace {

ForeignBody& at(ForeignModel& robot, int body) { return robot.bodies[static_cast<std::size_t>(body)]; }

/// Adds the mass properties of another body, which is at `pose` in the first one.
void add_mass(Body& body, const Body& other, const Pose& pose) {
  const double mass = body.mass + other.mass;
  const Vector3 other_com = pose.p + pose.R * other.com;
  const Matrix3 rotated_inertia = pose.R * other.inertia * pose.R.transpose();
  if (!(mass > 0)) {
    body.inertia += rotated_inertia;
    return;
  }
  if (body.mass == 0 && body.inertia.isZero(0)) {
    body.mass = mass;
    body.com = other_com;
    body.inertia = 0.5 * (rotated_inertia + rotated_inertia.transpose());
    return;
  }
  const Vector3 com = (body.mass * body.com + other.mass * other_com) / mass;
  const auto steiner_term = [](double m, const Vector3& r) { return Matrix3(-m * skew(r) * skew(r)); };
  const Matrix3 inertia = body.inertia + steiner_term(body.mass, body.com - com) + rotated_inertia +
                          steiner_term(other.mass, other_com - com);
  body.mass = mass;
  body.com = com;
  body.inertia = 0.5 * (inertia + inertia.transpose());
}

void move_joint(ForeignJoint& foreign_joint, int from, int to, const Pose& pose) {
  Joint& joint = foreign_joint.joint;
  if (joint.first == from) {
    joint.first = to;
    joint.point_first = pose.p + pose.R * joint.point_first;
    joint.axis = pose.R * joint.axis;
    joint.axis2 = pose.R * joint.axis2;
    joint.rotation = pose.R * joint.rotation;
    if (!pose.R.isIdentity(0)) foreign_joint.rpy.reset();
  }
  if (joint.second == from) {
    joint.second = to;
    joint.point_second = pose.p + pose.R * joint.point_second;
    joint.rotation = joint.rotation * pose.R.transpose();
    if (!pose.R.isIdentity(0)) foreign_joint.rpy.reset();
  }
}

/// Merges everything of `from`, which is at `pose` in `to`, into `to`.
void merge(ForeignModel& robot, int from, int to, const Pose& pose) {
  ForeignBody &source = at(robot, from), &target = at(robot, to);
  if (to != 0) add_mass(target.body, source.body, pose);
  target.merged_bodies.push_back({from, pose});
  for (const MergedBody& one : source.merged_bodies) target.merged_bodies.push_back({one.body, pose * one.pose});
  target.has_inertial = target.has_inertial || source.has_inertial;
  target.has_geometry = target.has_geometry || source.has_geometry;
  target.body.points.push_back({source.body.name, pose.p});
  for (const model::NamedPoint& point : source.body.points)
    target.body.points.push_back({point.name, pose.p + pose.R * point.position});
  source.body.points.clear();
  source.is_active = false;
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

/// A fixed joint within one body is either redundant or contradictory.
void check_consistent(const ForeignJoint& foreign_joint) {
  const Pose pose = joint_zero_pose(foreign_joint.joint);
  const double scale = std::max(1.0, foreign_joint.joint.point_first.norm());
  if (pose.p.norm() <= 1e-6 * scale && (pose.R - Matrix3::Identity()).norm() <= 1e-6) return;
  throw SpecError(
      {.place = foreign_joint.place,
       .message = fmt::format("joint {}: fixed joints contradict each other: what it joins is fixed elsewhere, "
                              "{:.3g} m away",
                              quote_for_message(foreign_joint.joint.name), pose.p.norm())});
}

}  // namespace

void merge_fixed_bodies(ForeignModel& robot) {
  std::vector<std::string> grounded_names, merged_names;
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
    const bool is_grounded = first == 0 || second == 0;
    (is_grounded ? grounded_names : merged_names).push_back(at(robot, second == 0 ? first : second).body.name);
    if (second == 0)
      merge(robot, first, second, pose.inverse());
    else
      merge(robot, second, first, pose);
  }
  const auto add_note = [&](const std::vector<std::string>& names, const char* into) {
    if (!names.empty())
      robot.findings.push_back({Severity::note,
                                {.file = robot.file},
                                "merged",
                                "",
                                fmt::format("merged into {}: {}", into, join_with_conjunction(names, "and"))});
  };
  add_note(merged_names, "what they are fixed to");
  add_note(grounded_names, "the ground");
}

namespace {

void check_something_moves(const ForeignModel& robot) {
  const auto is_active = [](const auto& one) { return one.is_active; };
  if (std::count_if(robot.bodies.begin(), robot.bodies.end(), is_active) > 1 &&
      std::any_of(robot.joints.begin(), robot.joints.end(), is_active))
    return;
  throw SpecError(
      {.place = {robot.file, 1, 1, ""}, .message = "expected something that moves: all of it is fixed to the ground"});
}

/// Fixes floating joints to the ground if `hold` is set, and rejects them otherwise.
void fix_floating_joints(ForeignModel& robot, bool is_base_fixed) {
  for (const ForeignJoint& one : robot.joints) {
    if (!one.is_active || !one.is_floating) continue;
    const std::string subject = fmt::format("joint {}", quote_for_message(one.joint.name));
    if (!is_base_fixed || one.joint.first != 0)
      throw SpecError({.place = one.place,
                       .message = fmt::format("{}: floating bodies are not imported{}", subject,
                                              one.joint.first == 0 ? "; --base fixed holds it where it is" : "")});
    robot.findings.push_back({Severity::note, one.place, "held", subject, "floats in the file and is held still"});
  }
}

/// Removes joints within one body: closures may join merged bodies, or two bodies of the ground.
void remove_internal_joints(ForeignModel& robot) {
  for (ForeignJoint& one : robot.joints) {
    if (!one.is_active || one.joint.first != one.joint.second) continue;
    one.is_active = false;
    robot.findings.push_back({Severity::warning, one.place, "within",
                              fmt::format("joint {}", quote_for_message(one.joint.name)),
                              "joins two parts of one body: left out"});
  }
  std::erase_if(robot.couplings, [&](const ForeignCoupling& one) {
    const auto is_removed = [&](int j) { return !robot.joints[static_cast<std::size_t>(j)].is_active; };
    return is_removed(one.follower) || is_removed(one.leader);
  });
  std::erase_if(robot.springs, [](const ForeignSpring& one) { return one.first == one.second; });
}

/// Makes each joint follow at most one other, and none itself. Reverses a coupling whose
/// follower already follows another.
void orient_couplings(ForeignModel& robot) {
  std::vector<int> leaders(robot.joints.size(), -1);
  const auto at = [](int joint) { return static_cast<std::size_t>(joint); };
  const auto is_leader_of = [&](int joint, int other) {  // up the chain of leaders
    while (other >= 0 && other != joint) other = leaders[at(other)];
    return other == joint;
  };
  for (ForeignCoupling& one : robot.couplings) {
    if (leaders[at(one.follower)] >= 0 && leaders[at(one.leader)] < 0) {
      std::swap(one.follower, one.leader);
      one.offset = -one.offset / one.ratio;
      one.ratio = 1 / one.ratio;
    }
    if (leaders[at(one.follower)] >= 0 || is_leader_of(one.follower, one.leader))
      throw SpecError(
          {.place = one.place,
           .message = fmt::format("expected a joint that follows only one other, found {}, which is coupled twice",
                                  quote_for_message(robot.joints[at(one.follower)].joint.name))});
    leaders[at(one.follower)] = one.leader;
  }
}

/// Checks that chains of joints connect all bodies to the ground.
void check_bodies_connected(const ForeignModel& robot) {
  std::vector<bool> reached(robot.bodies.size());
  if (!reached.empty()) reached[0] = true;
  for (bool has_grown = true; has_grown;) {
    has_grown = false;
    for (const ForeignJoint& one : robot.joints) {
      const auto first = static_cast<std::size_t>(one.joint.first), second = static_cast<std::size_t>(one.joint.second);
      if (!one.is_active || reached[first] == reached[second]) continue;
      reached[first] = reached[second] = has_grown = true;
    }
  }
  for (std::size_t b = 1; b < robot.bodies.size(); ++b)
    if (robot.bodies[b].is_active && !reached[b])
      throw SpecError({.place = robot.bodies[b].place,
                       .message = fmt::format("body {}: no chain of joints holds it: floating bodies are not imported",
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
