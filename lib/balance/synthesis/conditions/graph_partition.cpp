#include "balance/synthesis/conditions/graph_partition.hpp"

#include <algorithm>
#include <array>
#include <set>
#include <utility>

namespace balance::conditions {

namespace {

using Bodies = std::vector<BodyId>;

/// Connected components of the given bodies.
std::vector<Bodies> find_connected_components(const Mechanism& mechanism, const Bodies& bodies) {
  std::vector<int> label(mechanism.bodies.size(), -1);
  for (const int b : bodies) label[static_cast<std::size_t>(b)] = b;
  for (bool changed = true; changed;) {
    changed = false;
    for (const Joint& joint : mechanism.joints) {
      int &a = label[static_cast<std::size_t>(joint.first)], &b = label[static_cast<std::size_t>(joint.second)];
      if (a < 0 || b < 0 || a == b) continue;
      a = b = std::min(a, b);
      changed = true;
    }
  }
  std::vector<Bodies> out;
  for (const int representative : bodies) {
    if (label[static_cast<std::size_t>(representative)] != representative) continue;
    out.emplace_back();
    for (const int b : bodies)
      if (label[static_cast<std::size_t>(b)] == representative) out.back().push_back(b);
  }
  return out;
}

template <class Id>
bool contains(const std::vector<Id>& list, Id item) {
  return std::find(list.begin(), list.end(), item) != list.end();
}

std::vector<JointId> joints_of(const Mechanism& mechanism, BodyId body) {
  std::vector<JointId> out;
  for (std::size_t j = 0; j < mechanism.joints.size(); ++j)
    if (mechanism.joints[j].first == body || mechanism.joints[j].second == body) out.push_back(static_cast<int>(j));
  return out;
}

BodyId other_end(const Joint& joint, BodyId body) { return joint.first == body ? joint.second : joint.first; }

bool reaches_ground(const Mechanism& mechanism, const Bodies& bodies) {
  return std::any_of(mechanism.joints.begin(), mechanism.joints.end(), [&](const Joint& joint) {
    return (joint.first == model::ground && contains(bodies, joint.second)) ||
           (joint.second == model::ground && contains(bodies, joint.first));
  });
}

/// The part of the spec to which a body belongs, `leg1` for `leg1.crank`; empty for a body outside all parts.
std::string part_of(const Mechanism& mechanism, BodyId body) {
  const std::string& name = mechanism.bodies[static_cast<std::size_t>(body)].name;
  const auto dot = name.find('.');
  return dot == std::string::npos ? "" : name.substr(0, dot);
}

/// Number of parts with which a body outside all parts has joints; 0 for a body of a part.
int count_parts_at(const Mechanism& mechanism, BodyId body) {
  std::set<std::string> parts;
  for (const int j : joints_of(mechanism, body)) {
    const BodyId other = other_end(mechanism.joints[static_cast<std::size_t>(j)], body);
    if (const std::string part = part_of(mechanism, other); !part.empty()) parts.insert(part);
  }
  return part_of(mechanism, body).empty() ? static_cast<int>(parts.size()) : 0;
}

bool has_several_parts(const Mechanism& mechanism, const Bodies& bodies) {
  std::set<std::string> parts;
  for (const int b : bodies)
    if (const std::string part = part_of(mechanism, b); !part.empty()) parts.insert(part);
  return parts.size() > 1;
}

class GraphPartitioner {
 public:
  explicit GraphPartitioner(const Mechanism& mechanism) : mechanism_(mechanism) {
    partition_.chain_of.assign(mechanism.bodies.size(), -1);
  }

  GraphPartition run() {
    Bodies all;
    for (std::size_t b = 1; b < mechanism_.bodies.size(); ++b) all.push_back(static_cast<int>(b));
    for (const Bodies& component : find_connected_components(mechanism_, all)) {
      if (count_loops(component) == 0)
        add_chain(component);
      else if (!split_at_platform(component) && !open_loop(component))
        partition_.failure_reason =
            "the mechanism cannot be split into chains: it is not a single loop, and no body with three or more joints "
            "has several chains that all reach the ground";
    }
    return std::move(partition_);
  }

 private:
  int count_loops(const Bodies& component) const {
    const auto joint_count = std::count_if(mechanism_.joints.begin(), mechanism_.joints.end(), [&](const Joint& joint) {
      return contains(component, joint.first) || contains(component, joint.second);
    });
    return static_cast<int>(joint_count) - static_cast<int>(component.size());
  }

  void add_chain(const Bodies& bodies) {
    for (const int b : bodies) partition_.chain_of[static_cast<std::size_t>(b)] = partition_.chains;
    ++partition_.chains;
  }

  bool split_at_platform(const Bodies& component) {
    // by number of parts, then of joints; the tool's body first among equals
    std::vector<std::pair<std::array<int, 3>, int>> candidates;
    for (const int b : component) {
      const int joints = static_cast<int>(joints_of(mechanism_, b).size()), parts = count_parts_at(mechanism_, b);
      const bool tool = mechanism_.tool && mechanism_.tool->body == b;
      if (joints >= 3 || parts >= 2) candidates.push_back({{parts >= 2 ? -parts : 0, -joints, -tool}, b});
    }
    std::sort(candidates.begin(), candidates.end());
    for (const auto& [rank, body] : candidates) {
      Bodies rest = component;
      std::erase(rest, body);
      const std::vector<Bodies> chains = find_connected_components(mechanism_, rest);
      const bool reach_ground = std::all_of(chains.begin(), chains.end(),
                                            [&](const Bodies& chain) { return reaches_ground(mechanism_, chain); });
      if (chains.size() < 2 || !reach_ground) continue;
      const bool separates_parts = std::none_of(
          chains.begin(), chains.end(), [&](const Bodies& chain) { return has_several_parts(mechanism_, chain); });
      if (rank[0] < 0 && !separates_parts) continue;
      for (const Bodies& chain : chains) add_chain(chain);
      Platform platform{body, joints_of(mechanism_, body)};
      std::erase_if(platform.joints, [&, p = body](int j) {
        return other_end(mechanism_.joints[static_cast<std::size_t>(j)], p) == model::ground;
      });
      partition_.platforms.push_back(std::move(platform));
      return true;
    }
    return false;
  }

  bool open_loop(const Bodies& component) {
    const bool is_binary =
        std::all_of(component.begin(), component.end(), [&](int b) { return joints_of(mechanism_, b).size() <= 2; });
    if (!is_binary || count_loops(component) != 1 || component.size() < 2) return false;
    Bodies loop_bodies;
    const std::vector<JointId> joints = order_loop(component, loop_bodies);
    std::size_t cut_index = joints.size() / 2;
    for (std::size_t j = 1; j + 1 < joints.size(); ++j)
      if (is_tool_joint(mechanism_.joints[static_cast<std::size_t>(joints[j])])) cut_index = j;
    const auto is_between_parts = [&](std::size_t j) {
      return has_several_parts(mechanism_, {loop_bodies[j - 1], loop_bodies[j]});
    };
    for (std::size_t j = 1; j + 1 < joints.size(); ++j)
      if (!is_between_parts(cut_index) && is_between_parts(j)) cut_index = j;
    partition_.opened_joints.push_back(joints[cut_index]);
    const auto middle = loop_bodies.begin() + static_cast<std::ptrdiff_t>(cut_index);
    add_chain(Bodies(loop_bodies.begin(), middle));
    add_chain(Bodies(middle, loop_bodies.end()));
    return true;
  }

  /// Joints and bodies in order around the loop, from the ground to the ground.
  std::vector<JointId> order_loop(const Bodies& component, Bodies& loop_bodies) const {
    std::vector<JointId> joints;
    BodyId body = model::ground;
    do {
      for (std::size_t j = 0; j < mechanism_.joints.size(); ++j) {
        const Joint& joint = mechanism_.joints[j];
        const BodyId next = other_end(joint, body);
        if ((joint.first != body && joint.second != body) || contains(joints, JointId(static_cast<int>(j)))) continue;
        if (body == model::ground && !contains(component, next)) continue;
        joints.push_back(static_cast<int>(j));
        body = next;
        break;
      }
      if (body != model::ground) loop_bodies.push_back(body);
    } while (body != model::ground);
    return joints;
  }

  bool is_tool_joint(const Joint& joint) const {
    if (!mechanism_.tool || !is_point_joint(joint.type)) return false;
    const Tool& tool = *mechanism_.tool;
    const auto is_at = [&](BodyId body, const Vector3& point) {
      return body == tool.body &&
             (point - tool.position).norm() <= coincidence_tolerance * characteristic_length(mechanism_);
    };
    return is_at(joint.first, joint.point_first) || is_at(joint.second, joint.point_second);
  }

  const Mechanism& mechanism_;
  GraphPartition partition_;
};

}  // namespace

bool is_point_joint(JointType type) {
  return type == JointType::revolute || type == JointType::universal || type == JointType::spherical ||
         type == JointType::fixed;
}

GraphPartition partition_graph(const Mechanism& mechanism) { return GraphPartitioner(mechanism).run(); }

}  // namespace balance::conditions
