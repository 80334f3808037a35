#pragma once
/// Which joints' coordinates describe the mechanism and where its loops are cut.

#include "balance/mechanics/model/mechanism.hpp"

#include <cstddef>
#include <vector>

namespace balance {

/// The loops of a mechanism one by one: closed chains of bodies in which none occurs twice.
struct LoopStep {
  JointId joint = 0;
  bool forward = true;  ///< walked from its first body to its second
};

/// A loop, in the order in which it is walked.
using SimpleLoop = std::vector<LoopStep>;

/// @param most loops that are listed, the shortest first
std::vector<SimpleLoop> list_simple_loops(const Mechanism& mechanism, std::size_t most);

/// How a joint of the spanning tree is walked: from `parent` to `child`.
struct TreeEdge {
  JointId joint = 0;
  BodyId parent = 0;
  BodyId child = 0;     ///< meaningless for a split edge
  bool forward = true;  ///< the parent is the joint's first body
  /// The joint closes a loop, yet its coordinates are needed: it carries a massless copy of its child, and the loop is closed
  /// by welding that copy to the child.
  bool split = false;
};

struct SpanningTree {
  std::vector<TreeEdge> edges;  ///< parents before children; every moving body is the child of one unsplit edge
  std::vector<JointId> cut;     ///< joints enforced as loop closures, in the mechanism's order
};

/// Per joint: one of its coordinates is in `needed`, in a coupling, an actuator, followed by a disc or has friction.
std::vector<bool> find_needed_joints(const Mechanism& mechanism, const std::vector<CoordinateId>& needed);

/// A body between two spherical joints may spin about the line through them without anything else moving.
struct PassiveFreedom {
  BodyId body = 0;
  Vector3 line = Vector3::UnitZ();  ///< unit vector along it, in the body's axes
  JointId joints[2] = {0, 0};
};

/// Bodies whose spin nothing notices: exactly two joints, both spherical and not needed, the common CoM of body and attachments
/// on the line, no disc, spring or load on the body. Two bodies between spherical joints that slide along the line through these
/// spin together: each is listed, with the same joints, and one of them is to be held.
/// @param needed coordinates that must be available
std::vector<PassiveFreedom> passive_freedoms(const Mechanism& mechanism, const std::vector<CoordinateId>& needed);

/// Cuts the joints that leave the fewest coordinates; among equals those farthest from the ground, which keeps chains short.
/// Joints that are needed are never cut.
/// @param needed coordinates that must be available
/// @throws std::invalid_argument if a body is not connected to the ground
SpanningTree build_spanning_tree(const Mechanism& mechanism, const std::vector<CoordinateId>& needed);

/// The passive freedoms that a tree holds: of two bodies that spin together the one that its spherical joint carries.
std::vector<PassiveFreedom> locked_freedoms(const Mechanism& mechanism, const std::vector<CoordinateId>& needed,
                                            const SpanningTree& tree);

/// Bodies around the loop that a joint outside the tree closes, from its first body to its second.
std::vector<BodyId> loop_bodies(const Mechanism& mechanism, const SpanningTree& tree, JointId joint);

/// Degrees of freedom by counting (Grübler–Kutzbach), couplings included.
int count_degrees_of_freedom(const Mechanism& mechanism);

}  // namespace balance
