/// DART. It closes loops only while it integrates a motion in time, so they are closed here by the Jacobians of the cut
/// joints' points; `Skeleton::computeInverseDynamics` gives the forces of the tree.

#include "jacobian_peer.hpp"

#include <dart/config.hpp>
#include <dart/dynamics/BodyNode.hpp>
#include <dart/dynamics/PrismaticJoint.hpp>
#include <dart/dynamics/RevoluteJoint.hpp>
#include <dart/dynamics/Skeleton.hpp>
#include <dart/dynamics/WeldJoint.hpp>

#include <stdexcept>

namespace balance::peers {
namespace {

namespace dd = dart::dynamics;

class DartPeer : public JacobianPeer {
 public:
  explicit DartPeer(const RigidTree& tree) : JacobianPeer(tree), skeleton_(dd::Skeleton::create()) {
    for (const TreeBody& body : tree.bodies) add(body);
    skeleton_->setGravity(tree.gravity);
    if (static_cast<int>(skeleton_->getNumDofs()) != tree.motion_count())
      throw std::logic_error("DART has other joints");
  }

  const VectorX& compute_tree_forces(const VectorX& x, const VectorX& dx, const VectorX& ddx) override {
    skeleton_->setPositions(x);
    skeleton_->setVelocities(dx);
    skeleton_->setAccelerations(ddx);
    skeleton_->computeInverseDynamics();
    forces_ = skeleton_->getForces();
    return forces_;
  }

  WorldWrench ground_wrench() override {
    WorldWrench sum;
    for (std::size_t k = 0; k < skeleton_->getNumTrees(); ++k) {
      const dd::BodyNode* root = skeleton_->getRootBodyNode(k);
      const Eigen::Isometry3d& pose = root->getWorldTransform();
      const Vector3 moment = pose.linear() * root->getBodyForce().head<3>();
      const Vector3 force = pose.linear() * root->getBodyForce().tail<3>();
      sum.force += force;
      sum.moment += moment + Vector3(pose.translation()).cross(force);
    }
    return sum;
  }

 protected:
  void body_pose(int body, Matrix3& rotation, Vector3& origin) override {
    const Eigen::Isometry3d& pose = nodes_[body]->getWorldTransform();
    rotation = pose.linear();
    origin = pose.translation();
  }
  void frame_jacobian(int body, const Vector3& point_in_body, const Vector3&, FrameMotion& motion) override {
    const auto jacobian = nodes_[body]->getJacobian(point_in_body, dd::Frame::World());
    const auto& columns = nodes_[body]->getDependentGenCoordIndices();
    for (std::size_t k = 0; k < columns.size(); ++k) {
      motion.rotation_jacobian.col(columns[k]) = jacobian.col(k).head<3>();
      motion.point_jacobian.col(columns[k]) = jacobian.col(k).tail<3>();
    }
  }

 private:
  /// A body behind a chain of nearly massless ones, one for each of its motions but the last.
  void add(const TreeBody& body) {
    dd::BodyNode* node = body.parent == tree_ground ? nullptr : nodes_[body.parent];
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.translation() = body.position;
    const dd::Inertia inertia(body.mass, body.com, body.inertia);
    const dd::Inertia massless(negligible_mass, Vector3::Zero(), negligible_mass * Matrix3::Identity());
    const std::size_t count = body.motions.size();
    if (count == 0) node = add_joint<dd::WeldJoint>(node, {}, pose, inertia);
    for (std::size_t k = 0; k < count; ++k) {
      const dd::Inertia& carried = k + 1 == count ? inertia : massless;
      node = body.motions[k].is_rotation ? add_axis<dd::RevoluteJoint>(node, body.motions[k].axis, pose, carried)
                                         : add_axis<dd::PrismaticJoint>(node, body.motions[k].axis, pose, carried);
      pose.setIdentity();
    }
    nodes_.push_back(node);
  }

  template <class JointKind>
  dd::BodyNode* add_joint(dd::BodyNode* parent, typename JointKind::Properties properties,
                          const Eigen::Isometry3d& pose, const dd::Inertia& inertia) {
    const std::string number = std::to_string(skeleton_->getNumBodyNodes());
    properties.mName = "joint " + number;
    properties.mT_ParentBodyToJoint = pose;
    const dd::BodyNode::AspectProperties body("body " + number, inertia);
    return skeleton_->createJointAndBodyNodePair<JointKind>(parent, properties, dd::BodyNode::Properties(body)).second;
  }

  /// A joint about or along an axis.
  template <class JointKind>
  dd::BodyNode* add_axis(dd::BodyNode* parent, const Vector3& axis, const Eigen::Isometry3d& pose,
                         const dd::Inertia& inertia) {
    typename JointKind::Properties properties;
    properties.mAxis = axis;
    return add_joint<JointKind>(parent, properties, pose, inertia);
  }

  dd::SkeletonPtr skeleton_;
  std::vector<dd::BodyNode*> nodes_;
  VectorX forces_;
};

}  // namespace

PeerLibrary dart_library() {
  return {"DART", DART_VERSION, true,
          [](const RigidTree& tree) -> std::unique_ptr<Peer> { return std::make_unique<DartPeer>(tree); }};
}

}  // namespace balance::peers
