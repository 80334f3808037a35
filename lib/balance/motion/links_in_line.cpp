#include "balance/motion/links_in_line.hpp"

#include <algorithm>
#include <utility>
#include <vector>

namespace balance {

namespace {

constexpr double parallel_tolerance =
    1e-3;  // sine of the angle between two links in line: places are known to about its square
constexpr std::size_t max_listed_pairs = 3;  // in a sentence that is to be read

/// A place on a body at which something else is held: another joint, or the tool.
struct LinkEnd {
  JointId joint = -1;
  Vector3 position;
};

bool is_pivot(JointType type) {
  return type == JointType::revolute || type == JointType::universal || type == JointType::spherical;
}

template <class S>
Vector3 world_position(const Tree<S>& tree, const TreeState<S>& state, BodyId body, const Vector3& point) {
  FixedFrame<S> frame = tree.bodies[static_cast<std::size_t>(body)];
  frame.p_N += frame.R_N * to_vector<S>(point);
  return to_3d(position(state, frame));
}

/// By body.
template <class S>
std::vector<std::vector<LinkEnd>> list_link_ends(const Mechanism& mechanism, const Tree<S>& tree,
                                                 const TreeState<S>& state) {
  std::vector<std::vector<LinkEnd>> ends(mechanism.bodies.size());
  for (std::size_t j = 0; j < mechanism.joints.size(); ++j) {
    const Joint& joint = mechanism.joints[j];
    if (!is_pivot(joint.type)) continue;
    for (const auto& [body, point] : {std::pair(joint.first, joint.point_first), {joint.second, joint.point_second}})
      ends[static_cast<std::size_t>(body)].push_back({static_cast<int>(j), world_position(tree, state, body, point)});
  }
  if (mechanism.tool)
    ends[static_cast<std::size_t>(mechanism.tool->body)].push_back(
        {-1, world_position(tree, state, mechanism.tool->body, mechanism.tool->position)});
  return ends;
}

/// Some end of the one link, the joint and some end of the other lie on a straight line.
bool has_collinear_ends(const std::vector<LinkEnd>& first, const std::vector<LinkEnd>& second, JointId joint,
                        double min_length) {
  const auto at = [joint](const LinkEnd& end) { return end.joint == joint; };
  const auto a = std::find_if(first.begin(), first.end(), at), b = std::find_if(second.begin(), second.end(), at);
  for (const LinkEnd& from : first)
    for (const LinkEnd& to : second) {
      if (at(from) || at(to)) continue;
      const Vector3 u = from.position - a->position, v = to.position - b->position;
      const double lengths = u.norm() * v.norm();
      if (std::min(u.norm(), v.norm()) > min_length && u.cross(v).norm() <= parallel_tolerance * lengths) return true;
    }
  return false;
}

}  // namespace

template <class S>
std::string describe_collinear_links(const Mechanism& mechanism, const Tree<S>& tree, const TreeState<S>& state) {
  const auto ends = list_link_ends(mechanism, tree, state);
  std::string text;
  std::size_t pairs = 0;
  for (std::size_t j = 0; j < mechanism.joints.size(); ++j) {
    const Joint& joint = mechanism.joints[j];
    if (!is_pivot(joint.type) || joint.first == ground || joint.second == ground) continue;
    if (!has_collinear_ends(ends[static_cast<std::size_t>(joint.first)], ends[static_cast<std::size_t>(joint.second)],
                            static_cast<int>(j), 1e-6 * tree.characteristic_length))
      continue;
    if (++pairs > max_listed_pairs) return "";
    text += (text.empty() ? "" : ", ") + mechanism.bodies[joint.first].name + " and " +
            mechanism.bodies[joint.second].name + " are in line at " + joint.name;
  }
  return text;
}

template std::string describe_collinear_links<Planar>(const Mechanism&, const Tree<Planar>&, const TreeState<Planar>&);
template std::string describe_collinear_links<Spatial>(const Mechanism&, const Tree<Spatial>&,
                                                       const TreeState<Spatial>&);

}  // namespace balance
