#pragma once
/// A peer whose inverse dynamics knows no loops but which gives the Jacobian of any point: the cut joints' equations are
/// made from these.

#include "peer.hpp"

namespace balance::peers {

class JacobianPeer : public Peer {
 public:
  explicit JacobianPeer(const RigidTree& tree);
  const MatrixX& compute_closure_jacobian() override;
  double closure_residual() override;

 protected:
  /// Where a frame of a body is and how it moves with the tree's displacements.
  struct FrameMotion {
    Vector3 point = Vector3::Zero();
    Matrix3 axes = Matrix3::Identity();
    Eigen::Matrix3Xd point_jacobian, rotation_jacobian;  ///< 3 × motions, world axes
  };

  /// @param rotation, origin of the body, which is not the ground
  virtual void body_pose(int body, Matrix3& rotation, Vector3& origin) = 0;
  /// Fills both Jacobians of a body that is not the ground.
  /// @param point in world axes
  virtual void frame_jacobian(int body, const Vector3& point_in_body, const Vector3& point, FrameMotion& motion) = 0;

 private:
  void place(const BodyFrame& frame, FrameMotion& motion);

  std::vector<CutJoint> cut_joints_;
  MatrixX jacobian_;
  FrameMotion a_, b_;
};

}  // namespace balance::peers
