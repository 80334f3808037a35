#pragma once
/// Where a parallel mechanism falls apart into chains: the graph only.

#include "balance/mechanics/model/mechanism.hpp"

#include <string>
#include <vector>

namespace balance {

/// Points closer than this, beside the mechanism's length, are the same.
inline constexpr double coincidence_tolerance = 1e-9;

/// A body that several chains carry together.
struct Platform {
  BodyId body = 0;
  std::vector<JointId> joints;  ///< to the chains
};

struct GraphPartition {
  std::string failure_reason;  ///< why the mechanism cannot be split; empty if it can, or need not be
  int chains = 0;              ///< connected pieces that reach the ground; they may branch
  std::vector<int> chain_of;   ///< per body: its chain, −1 for the ground and platforms
  std::vector<Platform> platforms;
  std::vector<JointId> opened_joints;  ///< joints of loops without a platform
};

/// Everything that moves in one piece, the ground aside, is looked at by itself. Without loops it is a chain. With loops its
/// platform is the body with the most joints, at least three, whose removal leaves several pieces that all reach the
/// ground. A single loop of bodies with two joints each is opened at the joint at the tool's point, else at the joint halfway round.
///
/// Parts that the spec is made of (bodies `leg1.crank`, `leg1.coupler`) stay in one piece each where that is possible: then the platform is
/// the body of the whole that most parts carry, at least two, and a single loop is opened between two of them.
GraphPartition partition_graph(const Mechanism& mechanism);

/// Whether a joint holds one point of its first body at one point of its second.
bool is_point_joint(JointType type);

}  // namespace balance
