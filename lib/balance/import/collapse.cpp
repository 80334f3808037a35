#include "balance/base/elementary.hpp"
#include "balance/base/nearest.hpp"
#include "balance/import/simplify.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <set>

namespace balance::foreign {

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

}  // namespace balance::foreign
