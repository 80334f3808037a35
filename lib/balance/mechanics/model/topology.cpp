#include "balance/mechanics/model/topology.hpp"

#include "balance/mechanics/model/mechanism.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <queue>
#include <stdexcept>
#include <tuple>

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

namespace {

/// Walks from one body after the other, over later bodies only, so that every loop is met at its earliest body.
class SimpleLoopEnumerator {
 public:
  explicit SimpleLoopEnumerator(const Mechanism& mechanism)
      : mechanism_(mechanism), taken_(mechanism.bodies.size(), false) {}

  /// All loops of so many joints.
  void list(std::size_t length, std::size_t most, std::vector<SimpleLoop>& loops) {
    for (BodyId body = 0; body < static_cast<int>(mechanism_.bodies.size()); ++body)
      extend_path(body, body, length, most, loops);
  }
  bool is_budget_exhausted() const { return steps_ > max_search_steps; }

 private:
  static constexpr long max_search_steps = 200000;  ///< of the whole search, which grows exponentially

  void extend_path(int start, int here, std::size_t length, std::size_t most, std::vector<SimpleLoop>& loops) {
    if (way_.size() == length || loops.size() >= most || ++steps_ > max_search_steps) return;
    for (int j = 0; j < static_cast<int>(mechanism_.joints.size()); ++j) {
      const Joint& joint = mechanism_.joints[j];
      if (joint.first != here && joint.second != here) continue;
      const int there = joint.first == here ? joint.second : joint.first;
      const auto same = [j](const LoopStep& step) { return step.joint == j; };
      if (there < start || taken_[there] || std::any_of(way_.begin(), way_.end(), same)) continue;
      way_.push_back({j, joint.first == here});
      if (there != start) {
        taken_[there] = true;
        extend_path(start, there, length, most, loops);
        taken_[there] = false;
      } else if (way_.size() == length && way_.front().joint < j && loops.size() < most) {  // of the two directions one
        loops.push_back(way_);
      }
      way_.pop_back();
    }
  }

  const Mechanism& mechanism_;
  std::vector<bool> taken_;
  SimpleLoop way_;
  long steps_ = 0;
};

}  // namespace

std::vector<SimpleLoop> list_simple_loops(const Mechanism& mechanism, std::size_t most) {
  SimpleLoopEnumerator walk(mechanism);
  std::vector<SimpleLoop> loops;
  for (std::size_t length = 2; length <= mechanism.bodies.size() && loops.size() < most && !walk.is_budget_exhausted();
       ++length)
    walk.list(length, most, loops);
  return loops;
}

namespace {

/// Number of joints between each body and the ground.
std::vector<int> distances_from_ground(const Mechanism& mechanism) {
  std::vector<int> distance(mechanism.bodies.size(), -1);
  const std::vector<std::vector<JointId>> joints = joints_of_bodies(mechanism);
  std::queue<int> open;
  distance[ground] = 0;
  open.push(ground);
  while (!open.empty()) {
    const BodyId body = open.front();
    open.pop();
    for (const int j : joints[body]) {
      const Joint& joint = mechanism.joints[j];
      const int other = joint.first == body ? joint.second : joint.first;
      if (distance[other] >= 0) continue;
      distance[other] = distance[body] + 1;
      open.push(other);
    }
  }
  return distance;
}

int find_set_root(std::vector<int>& parent, int i) {
  while (parent[i] != i) i = parent[i] = parent[parent[i]];
  return i;
}

/// Walks the chosen joints from the ground outwards.
std::vector<TreeEdge> orient_edges(const Mechanism& mechanism, const std::vector<bool>& chosen) {
  std::vector<TreeEdge> edges;
  const std::vector<std::vector<JointId>> joints = joints_of_bodies(mechanism);
  std::vector<bool> reached(mechanism.bodies.size(), false);
  std::vector<int> open = {ground};
  reached[ground] = true;
  while (!open.empty()) {
    const BodyId body = open.back();
    open.pop_back();
    for (const int j : joints[body]) {
      const Joint& joint = mechanism.joints[j];
      if (!chosen[j]) continue;
      const int other = joint.first == body ? joint.second : joint.first;
      if (reached[other]) continue;
      reached[other] = true;
      edges.push_back({j, body, other, joint.first == body, false});
      open.push_back(other);
    }
  }
  if (std::find(reached.begin(), reached.end(), false) != reached.end())
    throw std::invalid_argument("a body is not connected to the ground");
  return edges;
}

}  // namespace

std::vector<bool> find_needed_joints(const Mechanism& mechanism, const std::vector<CoordinateId>& needed) {
  std::vector<bool> keep(mechanism.joints.size(), false);
  const auto mark = [&](int c) {
    const Coordinate& coordinate = mechanism.coordinates[c];
    // where a sphere touches the plane is told without the angles, which nobody then needs
    const bool place = mechanism.joints[coordinate.joint].type == JointType::rolling_sphere && coordinate.index < 2;
    keep[coordinate.joint] = keep[coordinate.joint] || !place;
  };
  for (const CoordinateId coordinate : needed) mark(coordinate);
  for (const CoordinateId coordinate : mechanism.actuators) mark(coordinate);
  const auto mark_all = [&](const CoordinateCombination& followed) {
    for (const CoordinateTerm& term : followed.terms) mark(term.coordinate);
  };
  for (const Coupling& coupling : mechanism.couplings) mark(coupling.follower), mark_all(coupling.leader);
  for (const Disc& disc : mechanism.discs) mark_all(disc.follows);
  for (const GeneralisedSpeed& constraint : mechanism.constraints)
    for (const GeneralisedSpeedTerm& term : constraint.terms)
      if (term.kind == GeneralisedSpeedTerm::Kind::coordinate) mark(term.index);
  for (const Friction& friction : mechanism.friction) mark(friction.coordinate);
  for (const Spring& spring : mechanism.springs)
    if (spring.is_joint_spring()) mark(spring.coordinate);
  return keep;
}

SpanningTree build_spanning_tree(const Mechanism& mechanism, const std::vector<CoordinateId>& needed) {
  const std::vector<int> distance = distances_from_ground(mechanism);
  std::vector<bool> keep = find_needed_joints(mechanism, needed);
  for (std::size_t j = 0; j < keep.size(); ++j) keep[j] = keep[j] || is_rolling(mechanism.joints[j].type);
  std::vector<int> order(mechanism.joints.size());
  std::iota(order.begin(), order.end(), 0);
  const auto rank = [&](int j) {
    const Joint& joint = mechanism.joints[j];
    return std::tuple(!keep[j], joint_degrees_of_freedom(joint.type),
                      std::min(distance[joint.first], distance[joint.second]), j);
  };
  std::sort(order.begin(), order.end(), [&](int a, int b) { return rank(a) < rank(b); });

  std::vector<int> group(mechanism.bodies.size());
  std::iota(group.begin(), group.end(), 0);
  std::vector<bool> chosen(mechanism.joints.size(), false);
  SpanningTree tree;
  std::vector<JointId> split;
  for (const int j : order) {
    const int a = find_set_root(group, mechanism.joints[j].first), b = find_set_root(group, mechanism.joints[j].second);
    if (a != b) {
      group[a] = b;
      chosen[j] = true;
    } else {
      (keep[j] ? split : tree.cut).push_back(j);
    }
  }
  std::sort(tree.cut.begin(), tree.cut.end());
  tree.edges = orient_edges(mechanism, chosen);
  for (const JointId j : split)
    tree.edges.push_back({j, mechanism.joints[j].first, mechanism.joints[j].second, true, true});
  return tree;
}

std::vector<BodyId> loop_bodies(const Mechanism& mechanism, const SpanningTree& tree, JointId joint) {
  std::vector<BodyId> parent(mechanism.bodies.size(), -1);
  for (const TreeEdge& edge : tree.edges)
    if (!edge.split) parent[edge.child] = edge.parent;
  const auto to_ground = [&](BodyId body) {
    std::vector<BodyId> path;
    for (; body >= 0; body = parent[body]) path.push_back(body);
    return path;
  };
  std::vector<BodyId> a = to_ground(mechanism.joints[joint].first), b = to_ground(mechanism.joints[joint].second);
  while (a.size() > 1 && b.size() > 1 && a[a.size() - 2] == b[b.size() - 2]) a.pop_back(), b.pop_back();
  if (!a.empty() && !b.empty() && a.back() == b.back()) b.pop_back();
  a.insert(a.end(), b.rbegin(), b.rend());
  return a;
}

int count_degrees_of_freedom(const Mechanism& mechanism) {
  const int per_body = mechanism.space == SpaceKind::planar ? 3 : 6;
  int freedoms =
      per_body * (static_cast<int>(mechanism.bodies.size()) - 1) - static_cast<int>(mechanism.couplings.size());
  for (const Joint& joint : mechanism.joints) freedoms -= per_body - joint_degrees_of_freedom(joint.type);
  return freedoms;
}

}  // namespace balance
