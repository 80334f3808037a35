#pragma once
/// Another library for multibody dynamics, with a RigidTree built in it by its own means.

#include "rigid_tree.hpp"

#include <memory>
#include <string>
#include <vector>

namespace balance::peers {

/// A force and its moment about the world's origin, world axes.
struct WorldWrench {
  Vector3 force = Vector3::Zero(), moment = Vector3::Zero();  ///< [N], [N m]
};

class Peer {
 public:
  virtual ~Peer() = default;

  /// Moves to a state and finds M ẍ + h of the tree, weight included and no force in the cut joints.
  /// @param x, dx, ddx per motion of the tree: displacements, rates, accelerations
  /// @return per motion, valid until the next call
  virtual const VectorX& compute_tree_forces(const VectorX& x, const VectorX& dx, const VectorX& ddx) = 0;

  // At the state of the last compute_tree_forces().

  /// Derivative of the cut joints' equations by the tree's displacements: equations × motions, with the peer's own
  /// choice of equations.
  virtual const MatrixX& compute_closure_jacobian() = 0;
  /// Largest violation of the cut joints' equations [m or rad].
  virtual double closure_residual() = 0;
  virtual bool gives_ground_wrench() const { return true; }
  /// What the ground exerts on the mechanism.
  virtual WorldWrench ground_wrench() { return {}; }
};

/// Whether a peer takes mechanisms with loops, and how it is made.
struct PeerLibrary {
  std::string name, version;
  bool has_loops = true;
  /// @throws std::runtime_error with the library's own words if it refuses the mechanism
  std::unique_ptr<Peer> (*make)(const RigidTree& tree);

  bool can_model(const RigidTree& tree) const { return has_loops || tree.cut_joints.empty(); }
};

PeerLibrary mujoco_library();
PeerLibrary dart_library();
PeerLibrary simbody_library();
PeerLibrary kdl_library();

}  // namespace balance::peers
