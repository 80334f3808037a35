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

namespace {

constexpr double line_coincidence_tolerance =
    1e-9;  // directions and, in metres, places: what written digits leave of a design

bool is_massless(const ForeignBody& one) { return one.body.mass == 0 && one.body.inertia.isZero(0); }

class MasslessBodyMerger {
 public:
  explicit MasslessBodyMerger(ForeignModel& robot) : robot_(robot) {
    for (const ForeignCoupling& coupling : robot.couplings) needed_.insert({coupling.follower, coupling.leader});
    for (const Spring& spring : robot.springs) carriers_.insert({spring.first, spring.second});
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

  bool is_free(int j) {
    const ForeignJoint& one = joint(j);
    return needed_.count(j) == 0 && !one.is_actuated && one.viscous == 0 && one.coulomb == 0 && one.stiffness == 0;
  }

  /// The two joints of a massless body that nothing else is on; both can be spared.
  std::optional<std::pair<int, int>> joints_of(int b) {
    const ForeignBody& one = robot_.bodies[static_cast<std::size_t>(b)];
    if (!one.is_active || !is_massless(one) || carriers_.count(b) > 0) return {};
    std::vector<int> found;
    for (int j = 0; j < static_cast<int>(robot_.joints.size()); ++j)
      if (joint(j).is_active && (joint(j).joint.first == b || joint(j).joint.second == b)) found.push_back(j);
    if (found.size() != 2 || !is_free(found[0]) || !is_free(found[1])) return {};
    return std::pair(found[0], found[1]);
  }

  /// The joint such that the body is its second, or its first.
  static Joint ending_in(const Joint& joint, int body) { return joint.second == body ? joint : reverse_joint(joint); }
  static Joint beginning_in(const Joint& joint, int body) { return joint.first == body ? joint : reverse_joint(joint); }

  static bool is_revolute(const Joint& joint) { return joint.type == JointType::revolute; }

  /// Where a revolute joint's line passes nearest to a point, all in the axes of the body that the line is given in.
  static Vector3 nearest_point_on_line(const Vector3& on_line, const Vector3& direction, const Vector3& point) {
    return on_line + direction * direction.dot(point - on_line);
  }

  void replace(int body, int kept, int gone, Joint together) {
    together.name = joint(kept).joint.name;
    joint(kept).joint = together;
    joint(kept).rpy.reset();
    joint(kept).limits = {};
    joint(kept).note =
        fmt::format("{} and {} with nothing between them", joint(kept).joint.name, joint(gone).joint.name);
    joint(gone).is_active = false;
    robot_.bodies[static_cast<std::size_t>(body)].is_active = false;
    const char* type = together.type == JointType::revolute    ? "revolute"
                       : together.type == JointType::universal ? "universal"
                                                               : "spherical";
    robot_.findings.push_back({Severity::note, joint(kept).place, "collapsed",
                               fmt::format("joint {}", quote_for_message(joint(kept).joint.name)),
                               fmt::format("with {} one {} joint: between them is no mass",
                                           quote_for_message(joint(gone).joint.name), type)});
  }

  /// a: P → M, b: M → Q, both revolute or one spherical.
  bool merge_joint_pair(int m) {
    const auto both = joints_of(m);
    if (!both) return false;
    const Joint &raw_a = joint(both->first).joint, &raw_b = joint(both->second).joint;
    const auto ball = [](const Joint& one) { return one.type == JointType::spherical; };
    if (ball(raw_a) != ball(raw_b) && (is_revolute(raw_a) || is_revolute(raw_b)))
      return merge_next_to_spherical(m, both->first, both->second);
    if (!is_revolute(raw_a) || !is_revolute(raw_b)) return false;
    const Joint a = ending_in(raw_a, m), b = beginning_in(raw_b, m);
    if (a.first == b.second) return false;
    const auto joined = merge_coaxial(a, b);
    if (joined) return replace(m, both->first, both->second, *joined), true;
    const auto crossed = merge_to_universal(a, b);
    if (crossed) return replace(m, both->first, both->second, *crossed), true;
    return false;
  }

  static Joint compose_joints(const Joint& a, const Joint& b) {
    Joint together = a;
    together.second = b.second;
    together.rotation = a.rotation * b.rotation;
    together.point_second = b.point_second;
    return together;
  }

  static std::optional<Joint> merge_coaxial(const Joint& a, const Joint& b) {
    const Vector3 u = a.rotation.transpose() * a.axis;  // in M
    const Vector3 between = b.point_first - a.point_second;
    if (u.cross(b.axis).norm() > line_coincidence_tolerance || u.cross(between).norm() > line_coincidence_tolerance)
      return {};
    Joint together = compose_joints(a, b);
    together.point_first = a.point_first + a.rotation * between;
    return together;
  }

  /// Where two lines in M meet; nothing if they do not.
  static std::optional<Vector3> intersect_lines(const Vector3& p, const Vector3& u, const Vector3& q,
                                                const Vector3& v) {
    const double square = 1 - elementary::pow(u.dot(v), 2);
    if (square < 1e-6) return {};
    const Vector3 d = q - p;
    const double s = (d.dot(u) - d.dot(v) * u.dot(v)) / square;
    const Vector3 meet = p + s * u;
    if ((nearest_point_on_line(q, v, meet) - meet).norm() > line_coincidence_tolerance) return {};
    return meet;
  }

  static std::optional<Joint> merge_to_universal(const Joint& a, const Joint& b) {
    const Vector3 u = a.rotation.transpose() * a.axis;
    if (std::abs(u.dot(b.axis)) > line_coincidence_tolerance) return {};
    const auto meet = intersect_lines(a.point_second, u, b.point_first, b.axis);
    if (!meet) return {};
    Joint together = compose_joints(a, b);
    together.type = JointType::universal;
    together.axis2 = a.rotation * b.axis;
    together.axis2 = (together.axis2 - together.axis2.dot(a.axis) * a.axis).normalized();
    // both points lie on their joint's line, which stands still in its own body
    together.point_first = a.point_first + a.rotation * (*meet - a.point_second);
    together.point_second = b.point_second + b.rotation.transpose() * (*meet - b.point_first);
    return together;
  }

  bool merge_next_to_spherical(int m, int j, int k) {
    if (is_revolute(joint(k).joint)) std::swap(j, k);  // j turns, k is the ball
    const Joint a = ending_in(joint(j).joint, m), ball = beginning_in(joint(k).joint, m);
    const Vector3 u = a.rotation.transpose() * a.axis;
    if (a.first == ball.second || u.cross(ball.point_first - a.point_second).norm() > line_coincidence_tolerance)
      return false;
    Joint together = compose_joints(a, ball);
    together.type = JointType::spherical;
    together.point_first = a.point_first + a.rotation * (ball.point_first - a.point_second);
    replace(m, k, j, together);
    return true;
  }

  /// a: P → M, b: M → N, c: N → Q, all revolute, M and N without mass, all lines through one point.
  bool merge_to_spherical(int m) {
    const auto both = joints_of(m);
    if (!both || !is_revolute(joint(both->first).joint) || !is_revolute(joint(both->second).joint)) return false;
    for (const auto& [ja, jb] : {std::pair(both->first, both->second), std::pair(both->second, both->first)}) {
      const Joint a = ending_in(joint(ja).joint, m), b = beginning_in(joint(jb).joint, m);
      const int n = b.second;
      const auto next = joints_of(n);
      if (!next || n == a.first) continue;
      const int jc = next->first == jb ? next->second : next->first;
      if (!is_revolute(joint(jc).joint)) continue;
      const Joint c = beginning_in(joint(jc).joint, n);
      if (c.second == a.first || c.second == m) continue;
      const auto ab = intersect_lines(a.point_second, a.rotation.transpose() * a.axis, b.point_first, b.axis);
      const auto bc = intersect_lines(b.point_second, b.rotation.transpose() * b.axis, c.point_first, c.axis);
      if (!ab || !bc) continue;
      const Vector3 ab_in_n = b.point_second + b.rotation.transpose() * (*ab - b.point_first);
      if ((ab_in_n - *bc).norm() > line_coincidence_tolerance) continue;
      Joint together = compose_joints(compose_joints(a, b), c);
      together.type = JointType::spherical;
      together.point_first = a.point_first + a.rotation * (*ab - a.point_second);
      together.point_second = c.point_second + c.rotation.transpose() * (*bc - c.point_first);
      replace(m, ja, jb, together);
      joint(jc).is_active = false;
      robot_.bodies[static_cast<std::size_t>(n)].is_active = false;
      return true;
    }
    return false;
  }

  ForeignModel& robot_;
  std::set<int> needed_;    ///< joints
  std::set<int> carriers_;  ///< bodies that something is fixed to
};

}  // namespace

void merge_massless_bodies(ForeignModel& robot) { MasslessBodyMerger(robot).run(); }

namespace {

/// Takes massless ends of chains off, one after the other.
class MasslessLeafRemover {
 public:
  explicit MasslessLeafRemover(ForeignModel& robot)
      : robot_(robot), on_(robot.bodies.size()), wanted_(robot.joints.size()) {
    for (std::size_t j = 0; j < robot.joints.size(); ++j) {
      const ForeignJoint& one = robot.joints[j];
      wanted_[j] = one.is_actuated;
      if (one.is_active)
        for (const int body : {one.joint.first, one.joint.second}) on_[at(body)].push_back(static_cast<int>(j));
    }
    for (const ForeignCoupling& coupling : robot.couplings) wanted_[at(coupling.leader)] = true;
    for (const Spring& spring : robot.springs) carriers_.insert({spring.first, spring.second});
  }

  void run() {
    for (int b = 1; b < static_cast<int>(robot_.bodies.size()); ++b)
      for (int end = b; end > 0;) end = drop(end);
    std::erase_if(robot_.couplings,
                  [&](const ForeignCoupling& one) { return !robot_.joints[at(one.follower)].is_active; });
  }

 private:
  static std::size_t at(int index) { return static_cast<std::size_t>(index); }

  /// @return the body that it hung on, which may be an end now; 0 if it stays
  int drop(int b) {
    ForeignBody& end = robot_.bodies[at(b)];
    if (!end.is_active || !is_massless(end) || carriers_.count(b) > 0 || on_[at(b)].size() != 1) return 0;
    const int j = on_[at(b)].front();
    ForeignJoint& only = robot_.joints[at(j)];
    if (wanted_[at(j)]) return 0;
    end.is_active = only.is_active = false;
    robot_.findings.push_back({Severity::warning, end.place, "empty-end",
                               fmt::format("link {}", quote_for_message(end.body.name)),
                               fmt::format("has no mass and carries nothing: left out with its joint {}",
                                           quote_for_message(only.joint.name))});
    const int other = only.joint.first == b ? only.joint.second : only.joint.first;
    std::erase(on_[at(other)], j);
    return other;
  }

  ForeignModel& robot_;
  std::vector<std::vector<int>> on_;  ///< joints of every body
  std::vector<bool> wanted_;          ///< joints whose coordinate somebody needs
  std::set<int> carriers_;            ///< bodies that something is fixed to
};

}  // namespace

void remove_massless_leaves(ForeignModel& robot) { MasslessLeafRemover(robot).run(); }

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
