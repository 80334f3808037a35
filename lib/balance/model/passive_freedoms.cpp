#include "balance/model/incidence.hpp"
#include "balance/model/spanning_tree.hpp"

#include <algorithm>
#include <cmath>

namespace balance {

namespace {

Vector3 point_on(const Joint& joint, BodyId body) {
  return joint.first == body ? joint.point_first : joint.point_second;
}

/// Something acts on the body from elsewhere than its joints.
bool has_external_elements(const Mechanism& mechanism, BodyId body) {
  const auto on = [body](const auto& part) { return part.body == body; };
  return std::any_of(mechanism.discs.begin(), mechanism.discs.end(), on) ||
         std::any_of(mechanism.loads.begin(), mechanism.loads.end(), on) ||
         std::any_of(mechanism.springs.begin(), mechanism.springs.end(),
                     [body](const Spring& spring) {
                       return !spring.is_joint_spring() && (spring.first == body || spring.second == body);
                     }) ||
         (mechanism.tool && mechanism.tool->body == body);
}

/// First moment of the body and what is fixed to it, divided by its mass; `otherwise` where there is none.
Vector3 common_com(const Mechanism& mechanism, BodyId body, const Vector3& otherwise) {
  double mass = mechanism.bodies[body].mass;
  Vector3 moment = mass * mechanism.bodies[body].com;
  for (const Attachment& extra : mechanism.attachments) {
    if (extra.body != body) continue;
    mass += extra.mass;
    moment += extra.mass * extra.position;
  }
  return mass > 0 ? Vector3(moment / mass) : otherwise;
}

constexpr double collinearity_tolerance = 1e-6;  // of the distance between the joints: what rounded coordinates leave

class PassiveFreedomFinder {
 public:
  PassiveFreedomFinder(const Mechanism& mechanism, const std::vector<CoordinateId>& needed)
      : mechanism_(mechanism), keep_(find_needed_joints(mechanism, needed)), on_(mechanism.bodies.size()) {
    for (std::size_t j = 0; j < mechanism.joints.size(); ++j)
      for (const BodyId body : {mechanism.joints[j].first, mechanism.joints[j].second})
        on_[body].push_back(static_cast<int>(j));
  }

  std::vector<PassiveFreedom> run() {
    for (BodyId body = 1; body < static_cast<int>(mechanism_.bodies.size()); ++body) find_rod(body);
    for (const Joint& joint : mechanism_.joints)
      if (joint.type == JointType::prismatic && joint.first != ground && joint.second != ground) find_leg(joint);
    return std::move(spins_);
  }

 private:
  bool may_spin_at(JointId joint) const {
    return mechanism_.joints[joint].type == JointType::spherical && !keep_[joint];
  }

  /// Its own and what it carries has its centre of mass on the line through a point.
  bool is_balanced(BodyId body, const Vector3& point, const Vector3& line, double length) const {
    const Vector3 off = line.cross(common_com(mechanism_, body, point) - point);
    return off.norm() <= collinearity_tolerance * length;
  }

  /// A body between two spherical joints.
  void find_rod(BodyId body) {
    const std::vector<JointId>& at = on_[body];
    if (at.size() != 2 || !may_spin_at(at[0]) || !may_spin_at(at[1]) || has_external_elements(mechanism_, body)) return;
    const Vector3 A = point_on(mechanism_.joints[at[0]], body), B = point_on(mechanism_.joints[at[1]], body);
    const double length = (B - A).norm();
    if (length == 0) return;
    const Vector3 line = (B - A) / length;
    if (is_balanced(body, A, line, length)) spins_.push_back({body, line, {at[0], at[1]}});
  }

  /// The other joint of a body with two, if it is a spherical one that may spin; −1 otherwise.
  int spherical_beside(BodyId body, const Joint& slide) const {
    if (on_[body].size() != 2 || has_external_elements(mechanism_, body)) return -1;
    const int other = &mechanism_.joints[on_[body][0]] == &slide ? on_[body][1] : on_[body][0];
    return may_spin_at(other) ? other : -1;
  }

  /// Two bodies that slide along the line through the spherical joint of each: they spin together.
  void find_leg(const Joint& slide) {
    const int lower = slide.first, upper = slide.second;
    const int first = spherical_beside(lower, slide), second = spherical_beside(upper, slide);
    if (first < 0 || second < 0) return;
    const Vector3 A = point_on(mechanism_.joints[first], lower), B = point_on(mechanism_.joints[second], upper);
    const Vector3 from_A = slide.point_first - A, to_B = slide.rotation * (B - slide.point_second);
    const double length = from_A.norm() + to_B.norm() + std::abs(slide.axis.dot(from_A + to_B));
    const Vector3 line_above = slide.rotation.transpose() * slide.axis;
    // wherever the slide stands, the second one is on the line through the first
    if (slide.axis.cross(from_A + to_B).norm() > collinearity_tolerance * length) return;
    if (!is_balanced(lower, A, slide.axis, length) || !is_balanced(upper, B, line_above, length)) return;
    spins_.push_back({lower, slide.axis, {first, second}});
    spins_.push_back({upper, line_above, {first, second}});
  }

  const Mechanism& mechanism_;
  const std::vector<bool> keep_;
  std::vector<std::vector<JointId>> on_;  ///< joints of every body
  std::vector<PassiveFreedom> spins_;
};

}  // namespace

std::vector<PassiveFreedom> passive_freedoms(const Mechanism& mechanism, const std::vector<CoordinateId>& needed) {
  return PassiveFreedomFinder(mechanism, needed).run();
}

std::vector<PassiveFreedom> locked_freedoms(const Mechanism& mechanism, const std::vector<CoordinateId>& needed,
                                            const SpanningTree& tree) {
  const std::vector<PassiveFreedom> all = passive_freedoms(mechanism, needed);
  const auto same = [](const PassiveFreedom& a, const PassiveFreedom& b) {
    return a.joints[0] == b.joints[0] && a.joints[1] == b.joints[1];
  };
  const auto carried = [&](const PassiveFreedom& spin) {
    return std::any_of(tree.edges.begin(), tree.edges.end(), [&](const TreeEdge& edge) {
      return !edge.split && edge.child == spin.body && (edge.joint == spin.joints[0] || edge.joint == spin.joints[1]);
    });
  };
  std::vector<PassiveFreedom> held;
  for (const PassiveFreedom& spin : all) {
    const auto alike = [&](const PassiveFreedom& one) { return same(one, spin); };
    const bool alone = std::count_if(all.begin(), all.end(), alike) == 1;
    if (alone || (carried(spin) && std::none_of(held.begin(), held.end(), alike))) held.push_back(spin);
  }
  return held;
}

}  // namespace balance
