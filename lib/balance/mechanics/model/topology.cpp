#include "balance/mechanics/model/topology.hpp"

#include "balance/mechanics/model/mechanism.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <queue>
#include <stdexcept>
#include <tuple>

namespace balance::model {

namespace {

Vector3 point_on(const Joint& joint, BodyId body) {
  return joint.first == body ? joint.point_first : joint.point_second;
}

/// Whether a disc, load, an end of a force between points or the tool is on the body.
bool has_external_elements(const Mechanism& mechanism, BodyId body) {
  const auto is_on_body = [body](const auto& element) { return element.body == body; };
  return std::any_of(mechanism.discs.begin(), mechanism.discs.end(), is_on_body) ||
         std::any_of(mechanism.loads.begin(), mechanism.loads.end(), is_on_body) ||
         std::any_of(mechanism.springs.begin(), mechanism.springs.end(),
                     [body](const Spring& spring) {
                       return !spring.is_joint_spring() && (spring.first == body || spring.second == body);
                     }) ||
         std::any_of(mechanism.force_elements.begin(), mechanism.force_elements.end(),
                     [body](const ForceElement& element) {
                       return !element.is_in_joint() && (element.first == body || element.second == body);
                     }) ||
         (mechanism.tool && mechanism.tool->body == body);
}

/// Common CoM of the body and its attachments; `fallback` if they have no mass.
Vector3 common_com(const Mechanism& mechanism, BodyId body, const Vector3& fallback) {
  double mass = mechanism.bodies[body].mass;
  Vector3 moment = mass * mechanism.bodies[body].com;
  for (const Attachment& attachment : mechanism.attachments) {
    if (attachment.body != body) continue;
    mass += attachment.mass;
    moment += attachment.mass * attachment.position;
  }
  return mass > 0 ? Vector3(moment / mass) : fallback;
}

constexpr double collinearity_tolerance = 1e-6;  // of the distance between the joints: allows for rounded input

class PassiveFreedomFinder {
 public:
  PassiveFreedomFinder(const Mechanism& mechanism, const std::vector<CoordinateId>& needed)
      : mechanism_(mechanism),
        is_needed_(find_needed_joints(mechanism, needed)),
        joints_of_body_(mechanism.bodies.size()) {
    for (std::size_t j = 0; j < mechanism.joints.size(); ++j)
      for (const BodyId body : {mechanism.joints[j].first, mechanism.joints[j].second})
        joints_of_body_[body].push_back(static_cast<int>(j));
  }

  std::vector<PassiveFreedom> run() {
    for (BodyId body = 1; body < static_cast<int>(mechanism_.bodies.size()); ++body) find_rod(body);
    for (const Joint& joint : mechanism_.joints)
      if (joint.type == JointType::prismatic && joint.first != ground && joint.second != ground) find_leg(joint);
    return std::move(freedoms_);
  }

 private:
  bool may_spin_at(JointId joint) const {
    return mechanism_.joints[joint].type == JointType::spherical && !is_needed_[joint];
  }

  /// Whether the common CoM of the body and its attachments lies on a line through `point`.
  bool is_balanced(BodyId body, const Vector3& point, const Vector3& line, double length) const {
    const Vector3 offset = line.cross(common_com(mechanism_, body, point) - point);
    return offset.norm() <= collinearity_tolerance * length;
  }

  /// A body between two spherical joints.
  void find_rod(BodyId body) {
    const std::vector<JointId>& joints = joints_of_body_[body];
    if (joints.size() != 2 || !may_spin_at(joints[0]) || !may_spin_at(joints[1]) ||
        has_external_elements(mechanism_, body))
      return;
    const Vector3 A = point_on(mechanism_.joints[joints[0]], body), B = point_on(mechanism_.joints[joints[1]], body);
    const double length = (B - A).norm();
    if (length == 0) return;
    const Vector3 line = (B - A) / length;
    if (is_balanced(body, A, line, length)) freedoms_.push_back({body, line, {joints[0], joints[1]}});
  }

  /// The other joint of a body with exactly two joints, if it is spherical and may spin; otherwise −1.
  int spherical_beside(BodyId body, const Joint& slide) const {
    if (joints_of_body_[body].size() != 2 || has_external_elements(mechanism_, body)) return -1;
    const int other =
        &mechanism_.joints[joints_of_body_[body][0]] == &slide ? joints_of_body_[body][1] : joints_of_body_[body][0];
    return may_spin_at(other) ? other : -1;
  }

  /// Two bodies that slide along the line through their spherical joints spin together.
  void find_leg(const Joint& slide) {
    const int lower = slide.first, upper = slide.second;
    const int first = spherical_beside(lower, slide), second = spherical_beside(upper, slide);
    if (first < 0 || second < 0) return;
    const Vector3 A = point_on(mechanism_.joints[first], lower), B = point_on(mechanism_.joints[second], upper);
    const Vector3 from_A = slide.point_first - A, to_B = slide.rotation * (B - slide.point_second);
    const double length = from_A.norm() + to_B.norm() + std::abs(slide.axis.dot(from_A + to_B));
    const Vector3 line_above = slide.rotation.transpose() * slide.axis;
    // the second joint must be on the line through the first for every position of the slide
    if (slide.axis.cross(from_A + to_B).norm() > collinearity_tolerance * length) return;
    if (!is_balanced(lower, A, slide.axis, length) || !is_balanced(upper, B, line_above, length)) return;
    freedoms_.push_back({lower, slide.axis, {first, second}});
    freedoms_.push_back({upper, line_above, {first, second}});
  }

  const Mechanism& mechanism_;
  const std::vector<bool> is_needed_;
  std::vector<std::vector<JointId>> joints_of_body_;  ///< joints of every body
  std::vector<PassiveFreedom> freedoms_;
};

}  // namespace

std::vector<PassiveFreedom> passive_freedoms(const Mechanism& mechanism, const std::vector<CoordinateId>& needed) {
  return PassiveFreedomFinder(mechanism, needed).run();
}

std::vector<PassiveFreedom> locked_freedoms(const Mechanism& mechanism, const std::vector<CoordinateId>& needed,
                                            const SpanningTree& tree) {
  const std::vector<PassiveFreedom> candidates = passive_freedoms(mechanism, needed);
  const auto shares_joints = [](const PassiveFreedom& a, const PassiveFreedom& b) {
    return a.joints[0] == b.joints[0] && a.joints[1] == b.joints[1];
  };
  const auto is_carried = [&](const PassiveFreedom& freedom) {
    return std::any_of(tree.edges.begin(), tree.edges.end(), [&](const TreeEdge& edge) {
      return !edge.split && edge.child == freedom.body &&
             (edge.joint == freedom.joints[0] || edge.joint == freedom.joints[1]);
    });
  };
  std::vector<PassiveFreedom> locked;
  for (const PassiveFreedom& freedom : candidates) {
    const auto shares_joints_with_freedom = [&](const PassiveFreedom& other) { return shares_joints(other, freedom); };
    const bool is_single = std::count_if(candidates.begin(), candidates.end(), shares_joints_with_freedom) == 1;
    if (is_single || (is_carried(freedom) && std::none_of(locked.begin(), locked.end(), shares_joints_with_freedom)))
      locked.push_back(freedom);
  }
  return locked;
}

namespace {

/// Searches from each body over bodies of higher index only, so that every loop is found from its lowest body.
class SimpleLoopEnumerator {
 public:
  explicit SimpleLoopEnumerator(const Mechanism& mechanism)
      : mechanism_(mechanism), is_visited_(mechanism.bodies.size(), false) {}

  /// Appends all loops of `length` joints, up to `max_loops` loops in total.
  void list(std::size_t length, std::size_t max_loops, std::vector<SimpleLoop>& loops) {
    for (BodyId body = 0; body < static_cast<int>(mechanism_.bodies.size()); ++body)
      extend_path(body, body, length, max_loops, loops);
  }
  bool is_budget_exhausted() const { return steps_ > max_search_steps; }

 private:
  static constexpr long max_search_steps = 200000;  ///< for the whole search, whose cost grows exponentially

  void extend_path(int start, int body, std::size_t length, std::size_t max_loops, std::vector<SimpleLoop>& loops) {
    if (path_.size() == length || loops.size() >= max_loops || ++steps_ > max_search_steps) return;
    for (int j = 0; j < static_cast<int>(mechanism_.joints.size()); ++j) {
      const Joint& joint = mechanism_.joints[j];
      if (joint.first != body && joint.second != body) continue;
      const int next_body = joint.first == body ? joint.second : joint.first;
      const auto is_same_joint = [j](const LoopStep& step) { return step.joint == j; };
      if (next_body < start || is_visited_[next_body] || std::any_of(path_.begin(), path_.end(), is_same_joint))
        continue;
      path_.push_back({j, joint.first == body});
      if (next_body != start) {
        is_visited_[next_body] = true;
        extend_path(start, next_body, length, max_loops, loops);
        is_visited_[next_body] = false;
      } else if (path_.size() == length && path_.front().joint < j && loops.size() < max_loops) {  // one direction only
        loops.push_back(path_);
      }
      path_.pop_back();
    }
  }

  const Mechanism& mechanism_;
  std::vector<bool> is_visited_;
  SimpleLoop path_;
  long steps_ = 0;
};

}  // namespace

std::vector<SimpleLoop> list_simple_loops(const Mechanism& mechanism, std::size_t max_loops) {
  SimpleLoopEnumerator enumerator(mechanism);
  std::vector<SimpleLoop> loops;
  for (std::size_t length = 2;
       length <= mechanism.bodies.size() && loops.size() < max_loops && !enumerator.is_budget_exhausted(); ++length)
    enumerator.list(length, max_loops, loops);
  return loops;
}

namespace {

/// Number of joints between each body and the ground; −1 if it is not connected.
std::vector<int> distances_from_ground(const Mechanism& mechanism) {
  std::vector<int> distance(mechanism.bodies.size(), -1);
  const std::vector<std::vector<JointId>> joints = joints_of_bodies(mechanism);
  std::queue<int> pending;
  distance[ground] = 0;
  pending.push(ground);
  while (!pending.empty()) {
    const BodyId body = pending.front();
    pending.pop();
    for (const int j : joints[body]) {
      const Joint& joint = mechanism.joints[j];
      const int other = joint.first == body ? joint.second : joint.first;
      if (distance[other] >= 0) continue;
      distance[other] = distance[body] + 1;
      pending.push(other);
    }
  }
  return distance;
}

int find_set_root(std::vector<int>& parent, int i) {
  while (parent[i] != i) i = parent[i] = parent[parent[i]];
  return i;
}

/// Traverses the chosen joints from the ground outwards.
std::vector<TreeEdge> orient_edges(const Mechanism& mechanism, const std::vector<bool>& chosen) {
  std::vector<TreeEdge> edges;
  const std::vector<std::vector<JointId>> joints = joints_of_bodies(mechanism);
  std::vector<bool> is_reached(mechanism.bodies.size(), false);
  std::vector<int> pending = {ground};
  is_reached[ground] = true;
  while (!pending.empty()) {
    const BodyId body = pending.back();
    pending.pop_back();
    for (const int j : joints[body]) {
      const Joint& joint = mechanism.joints[j];
      if (!chosen[j]) continue;
      const int other = joint.first == body ? joint.second : joint.first;
      if (is_reached[other]) continue;
      is_reached[other] = true;
      edges.push_back({j, body, other, joint.first == body, false});
      pending.push_back(other);
    }
  }
  if (std::find(is_reached.begin(), is_reached.end(), false) != is_reached.end())
    throw std::invalid_argument("a body is not connected to the ground");
  return edges;
}

}  // namespace

std::vector<bool> find_needed_joints(const Mechanism& mechanism, const std::vector<CoordinateId>& needed) {
  std::vector<bool> is_needed(mechanism.joints.size(), false);
  const auto mark_needed = [&](int c) {
    const Coordinate& coordinate = mechanism.coordinates[c];
    // the contact point of a sphere is known without the angles, so it does not need them
    const bool is_contact_position =
        mechanism.joints[coordinate.joint].type == JointType::rolling_sphere && coordinate.index < 2;
    is_needed[coordinate.joint] = is_needed[coordinate.joint] || !is_contact_position;
  };
  for (const CoordinateId coordinate : needed) mark_needed(coordinate);
  for (const CoordinateId coordinate : mechanism.actuators) mark_needed(coordinate);
  const auto mark_terms = [&](const CoordinateCombination& followed) {
    for (const CoordinateTerm& term : followed.terms) mark_needed(term.coordinate);
  };
  for (const Coupling& coupling : mechanism.couplings) mark_needed(coupling.follower), mark_terms(coupling.leader);
  for (const Disc& disc : mechanism.discs) mark_terms(disc.follows);
  for (const GeneralisedSpeed& constraint : mechanism.constraints)
    for (const GeneralisedSpeedTerm& term : constraint.terms)
      if (term.kind == GeneralisedSpeedTerm::Kind::coordinate) mark_needed(term.index);
  for (const Friction& friction : mechanism.friction) mark_needed(friction.coordinate);
  for (const Spring& spring : mechanism.springs)
    if (spring.is_joint_spring()) mark_needed(spring.coordinate);
  for (const Load& load : mechanism.loads)
    if (load.is_over_coordinate()) mark_needed(load.coordinate);
  for (const ForceElement& element : mechanism.force_elements)
    if (element.is_in_joint()) mark_needed(element.coordinate);
  return is_needed;
}

SpanningTree build_spanning_tree(const Mechanism& mechanism, const std::vector<CoordinateId>& needed) {
  const std::vector<int> distance = distances_from_ground(mechanism);
  std::vector<bool> is_needed = find_needed_joints(mechanism, needed);
  for (std::size_t j = 0; j < is_needed.size(); ++j)
    is_needed[j] = is_needed[j] || is_rolling(mechanism.joints[j].type);
  std::vector<int> order(mechanism.joints.size());
  std::iota(order.begin(), order.end(), 0);
  const auto sort_key = [&](int j) {
    const Joint& joint = mechanism.joints[j];
    return std::tuple(!is_needed[j], joint_degrees_of_freedom(joint.type),
                      std::min(distance[joint.first], distance[joint.second]), j);
  };
  std::sort(order.begin(), order.end(), [&](int a, int b) { return sort_key(a) < sort_key(b); });

  std::vector<int> set_parent(mechanism.bodies.size());
  std::iota(set_parent.begin(), set_parent.end(), 0);
  std::vector<bool> chosen(mechanism.joints.size(), false);
  SpanningTree tree;
  std::vector<JointId> split;
  for (const int j : order) {
    const int a = find_set_root(set_parent, mechanism.joints[j].first),
              b = find_set_root(set_parent, mechanism.joints[j].second);
    if (a != b) {
      set_parent[a] = b;
      chosen[j] = true;
    } else {
      (is_needed[j] ? split : tree.cut).push_back(j);
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

}  // namespace balance::model
