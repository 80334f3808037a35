#pragma once
/// How a parallel mechanism splits into chains: the graph only.

#include "balance/mechanics/model/mechanism.hpp"

#include <string>
#include <vector>

namespace balance::conditions {

/// Points closer than this, relative to the mechanism's length, coincide.
inline constexpr double coincidence_tolerance = 1e-9;

/// A body that several chains carry together.
struct Platform {
  BodyId body = 0;
  std::vector<JointId> joints;  ///< joints with the chains
};

struct GraphPartition {
  std::string failure_reason;  ///< why the mechanism cannot be split; empty if it can be or need not be
  int chains = 0;              ///< number of connected components that reach the ground; they may branch
  std::vector<int> chain_of;   ///< per body: its chain, −1 for the ground and platforms
  std::vector<Platform> platforms;
  std::vector<JointId> opened_joints;  ///< opened in loops without a platform
};

/// Treats every connected component, without the ground, separately. Without loops it is a chain. With loops, its
/// platform is the body with the most joints, at least three, whose removal leaves several components that all reach
/// the ground. A single loop of bodies with two joints each is opened at the joint at the tool's point, otherwise at
/// the joint halfway round.
///
/// Parts of which the spec is composed (bodies `leg1.crank`, `leg1.coupler`) are not split if possible: the platform is
/// then the body outside all parts that the largest number of parts carries, at least two, and a single loop is opened
/// between two parts.
GraphPartition partition_graph(const Mechanism& mechanism);

/// Whether a joint makes a point of its first body coincide with a point of its second.
bool is_point_joint(JointType type);

}  // namespace balance::conditions
