/// KDL (Orocos): the recursive Newton–Euler method on trees. It has no loops, and the wrench at the ground stays inside.

#include "peer.hpp"

#include <kdl/config.h>
#include <kdl/tree.hpp>
#include <kdl/treeidsolver_recursive_newton_euler.hpp>

#include <stdexcept>

namespace balance::peers {
namespace {

KDL::Vector to_kdl(const Vector3& v) { return {v.x(), v.y(), v.z()}; }

KDL::RigidBodyInertia to_kdl(const TreeBody& body) {
  const Matrix3& i = body.inertia;
  return KDL::RigidBodyInertia(body.mass, to_kdl(body.com),
                               KDL::RotationalInertia(i(0, 0), i(1, 1), i(2, 2), i(0, 1), i(0, 2), i(1, 2)));
}

class KdlPeer : public Peer {
 public:
  explicit KdlPeer(const RigidTree& tree)
      : names_(make(tree)),
        solver_(tree_, to_kdl(tree.gravity)),
        x_(tree_.getNrOfJoints()),
        dx_(x_),
        ddx_(x_),
        forces_(x_),
        tree_forces_(tree.motion_count()) {
    for (const std::string& name : names_)
      index_.push_back(static_cast<int>(GetTreeElementQNr(tree_.getSegment(name)->second)));
  }

  const VectorX& compute_tree_forces(const VectorX& x, const VectorX& dx, const VectorX& ddx) override {
    for (std::size_t k = 0; k < index_.size(); ++k) {
      x_(index_[k]) = x[k];
      dx_(index_[k]) = dx[k];
      ddx_(index_[k]) = ddx[k];
    }
    if (solver_.CartToJnt(x_, dx_, ddx_, no_forces_, forces_) != 0) throw std::runtime_error("KDL found no forces");
    for (std::size_t k = 0; k < index_.size(); ++k) tree_forces_[k] = forces_(index_[k]);
    return tree_forces_;
  }

  const MatrixX& compute_closure_jacobian() override { return no_loops_; }
  double closure_residual() override { return 0; }
  bool gives_ground_wrench() const override { return false; }

 private:
  /// A body behind a chain of massless segments, one for each of its motions but the last.
  /// @return names of the segments that move, in the order of the motions
  std::vector<std::string> make(const RigidTree& tree) {
    std::vector<std::string> moved, bodies;
    for (const TreeBody& body : tree.bodies) {
      std::string hook = body.parent == tree_ground ? tree_.getRootSegment()->first : bodies[body.parent];
      KDL::Vector position = to_kdl(body.position);
      const auto add = [&](const KDL::Joint& joint, const KDL::RigidBodyInertia& inertia) {
        const std::string name = "segment " + std::to_string(tree_.getNrOfSegments());
        tree_.addSegment(KDL::Segment(name, joint, KDL::Frame(position), inertia), hook);
        hook = name;
        position = KDL::Vector::Zero();
      };
      const std::size_t count = body.motions.size();
      if (count == 0) add(KDL::Joint(KDL::Joint::Fixed), to_kdl(body));
      for (std::size_t k = 0; k < count; ++k) {
        const KDL::Joint joint("joint", position, to_kdl(body.motions[k].axis),
                               body.motions[k].is_rotation ? KDL::Joint::RotAxis : KDL::Joint::TransAxis);
        add(joint, k + 1 == count ? to_kdl(body) : KDL::RigidBodyInertia::Zero());
        moved.push_back(hook);
      }
      bodies.push_back(hook);
    }
    return moved;
  }

  KDL::Tree tree_;
  std::vector<std::string> names_;
  KDL::TreeIdSolver_RNE solver_;
  KDL::JntArray x_, dx_, ddx_, forces_;
  KDL::WrenchMap no_forces_;
  std::vector<int> index_;
  VectorX tree_forces_;
  MatrixX no_loops_;
};

}  // namespace

PeerLibrary kdl_library() {
  return {"KDL", KDL_VERSION_STRING, false,
          [](const RigidTree& tree) -> std::unique_ptr<Peer> { return std::make_unique<KdlPeer>(tree); }};
}

}  // namespace balance::peers
