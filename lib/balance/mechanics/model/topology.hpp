#pragma once
/// Spanning tree and loops of a mechanism: which joint coordinates describe it and where its loops are cut.

#include "balance/mechanics/model/mechanism.hpp"

#include <cstddef>
#include <vector>

namespace balance::model {

/// One joint of a simple loop, a closed chain in which no body occurs twice.
struct LoopStep {
  JointId joint = 0;
  bool forward = true;  ///< traversed from its first body to its second
};

/// A loop, in order of traversal.
using SimpleLoop = std::vector<LoopStep>;

/// @param max_loops maximum number of loops; shorter loops come first
std::vector<SimpleLoop> list_simple_loops(const Mechanism& mechanism, std::size_t max_loops);

/// A joint of the spanning tree, traversed from `parent` to `child`.
struct TreeEdge {
  JointId joint = 0;
  BodyId parent = 0;
  BodyId child = 0;     ///< meaningless for a split edge
  bool forward = true;  ///< the parent is the joint's first body
  /// The joint closes a loop but its coordinates are needed. It carries a massless copy of its child, and the loop is
  /// closed by welding that copy to the child.
  bool split = false;
};

struct SpanningTree {
  std::vector<TreeEdge> edges;  ///< parents before children; every moving body is the child of one unsplit edge
  std::vector<JointId> cut;     ///< joints enforced as loop closures, in the mechanism's order
};

/// Per joint, whether it has a coordinate that is in `needed`, coupled, actuated, constrained, followed by a disc, or
/// has friction or a spring.
std::vector<bool> find_needed_joints(const Mechanism& mechanism, const std::vector<CoordinateId>& needed);

/// A body between two spherical joints that may spin about the line through them while nothing else moves.
struct PassiveFreedom {
  BodyId body = 0;
  Vector3 line = Vector3::UnitZ();  ///< unit vector along the line, in the body's axes
  JointId joints[2] = {0, 0};
};

/// Bodies whose spin has no effect: they have exactly two joints, both spherical and not needed; the common CoM of body
/// and attachments lies on the line; no disc, spring, load or tool is on the body. Two bodies between spherical joints
/// that slide along the line through these joints spin together. Both are listed, with the same joints, and one of them
/// must be held.
/// @param needed coordinates that must be available
std::vector<PassiveFreedom> passive_freedoms(const Mechanism& mechanism, const std::vector<CoordinateId>& needed);

/// Minimises the number of coordinates. Among equals, cuts the joints farthest from the ground, which keeps chains
/// short. Never cuts needed or rolling joints.
/// @param needed coordinates that must be available
/// @throws std::invalid_argument if a body is not connected to the ground
SpanningTree build_spanning_tree(const Mechanism& mechanism, const std::vector<CoordinateId>& needed);

/// The passive freedoms that a tree holds. Of two bodies that spin together, it holds the child of their spherical
/// joint.
std::vector<PassiveFreedom> locked_freedoms(const Mechanism& mechanism, const std::vector<CoordinateId>& needed,
                                            const SpanningTree& tree);

/// Bodies around the loop closed by a joint outside the tree, from the joint's first body to its second.
std::vector<BodyId> loop_bodies(const Mechanism& mechanism, const SpanningTree& tree, JointId joint);

/// Degrees of freedom by the Grübler–Kutzbach count, including couplings.
int count_degrees_of_freedom(const Mechanism& mechanism);

}  // namespace balance::model
