#include "balance/model/spanning_tree.hpp"

#include "balance/model/incidence.hpp"

#include <algorithm>
#include <numeric>
#include <queue>
#include <stdexcept>
#include <tuple>

namespace balance {

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
