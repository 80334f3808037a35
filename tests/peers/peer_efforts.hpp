#pragma once
/// Actuator efforts of a mechanism from a peer's equations. With f the forces of the tree's motions, K the motions per
/// rate of the independent coordinates, S the generalised forces of unit efforts u, and J the derivative of the cut
/// joints' equations,
///
///     Kᵀ f = S u + (J K)ᵀ λ.

#include "peer.hpp"

#include <Eigen/LU>

#include <vector>

namespace balance::peers {

class PeerEfforts {
 public:
  /// Chooses equations of the cut joints that are independent at a state: a planar loop in space has some that are not.
  /// @param x, dx, ddx per motion of the tree
  /// @throws NotComparable if the equations there do not determine the efforts
  PeerEfforts(const RigidTree& tree, Peer& peer, const VectorX& x, const VectorX& dx, const VectorX& ddx);

  /// @return per actuator [N m or N], valid until the next call
  const VectorX& compute(const VectorX& x, const VectorX& dx, const VectorX& ddx);

 private:
  Peer& peer_;
  MatrixX motions_, efforts_;  ///< K, S
  MatrixX open_tree_;          ///< u = open_tree_ · f without loops
  std::vector<Eigen::Index> rows_;
  MatrixX matrix_;
  VectorX right_side_, solution_, effort_;
  Eigen::PartialPivLU<MatrixX> lu_;
};

}  // namespace balance::peers
