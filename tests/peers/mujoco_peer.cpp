/// MuJoCo. Its equality constraints are soft springs without an exact inverse, so loops are closed by the Jacobians of
/// the cut joints' points (`mj_jac`), and `mj_rne` gives the forces of the tree.

#include "jacobian_peer.hpp"

#include <mujoco/mujoco.h>
#include <Eigen/Eigenvalues>

#include <fmt/format.h>

#include <cstring>
#include <memory>
#include <stdexcept>

namespace balance::peers {
namespace {

std::string numbers(const Vector3& v) { return fmt::format("{:.17g} {:.17g} {:.17g}", v.x(), v.y(), v.z()); }

/// MuJoCo's own decomposition of an inertia takes none with a very small moment, hence principal axes and moments.
std::string format_inertial(const TreeBody& body) {
  const Eigen::SelfAdjointEigenSolver<Matrix3> principal(body.inertia);
  Matrix3 axes = principal.eigenvectors();
  axes.col(2) = axes.col(0).cross(axes.col(1));
  const Eigen::Quaterniond q(axes);
  return fmt::format("<inertial pos='{}' quat='{:.17g} {}' mass='{:.17g}' diaginertia='{}'/>\n", numbers(body.com),
                     q.w(), numbers(q.vec()), body.mass, numbers(principal.eigenvalues().cwiseMax(negligible_mass)));
}

std::string format_children(const RigidTree& tree, int parent) {
  std::string text;
  for (int b = parent + 1; b < static_cast<int>(tree.bodies.size()); ++b) {
    const TreeBody& body = tree.bodies[b];
    if (body.parent != parent) continue;
    text += fmt::format("<body pos='{}'>\n", numbers(body.position));
    for (const ElementaryMotion& motion : body.motions)
      text +=
          fmt::format("<joint type='{}' axis='{}'/>\n", motion.is_rotation ? "hinge" : "slide", numbers(motion.axis));
    text += format_inertial(body) + format_children(tree, b) + "</body>\n";
  }
  return text;
}

std::string format_mjcf(const RigidTree& tree) {
  return fmt::format("<mujoco><compiler angle='radian'/><option gravity='{}'/>\n<worldbody>\n{}</worldbody></mujoco>\n",
                     numbers(tree.gravity), format_children(tree, tree_ground));
}

struct Deleter {
  void operator()(mjModel* model) const { mj_deleteModel(model); }
  void operator()(mjData* data) const { mj_deleteData(data); }
  void operator()(mjVFS* files) const {
    mj_deleteVFS(files);
    delete files;
  }
};

std::unique_ptr<mjModel, Deleter> load(const std::string& text) {
  const std::unique_ptr<mjVFS, Deleter> files(new mjVFS);
  mj_defaultVFS(files.get());
  mj_makeEmptyFileVFS(files.get(), "tree.xml", static_cast<int>(text.size()));
  std::memcpy(files->filedata[0], text.data(), text.size());
  char message[1000] = "";
  std::unique_ptr<mjModel, Deleter> model(mj_loadXML("tree.xml", files.get(), message, sizeof message));
  if (!model) throw std::runtime_error(message);
  return model;
}

class MujocoPeer : public JacobianPeer {
 public:
  explicit MujocoPeer(const RigidTree& tree) : JacobianPeer(tree), model_(load(format_mjcf(tree))) {
    data_.reset(mj_makeData(model_.get()));
    if (model_->nv != tree.motion_count() || model_->nbody != static_cast<int>(tree.bodies.size()) + 1)
      throw std::logic_error("MuJoCo has other bodies or joints");  // both count depth first
    forces_.resize(model_->nv);
    point_rows_.resize(3, model_->nv);
    rotation_rows_.resize(3, model_->nv);
  }

  const VectorX& compute_tree_forces(const VectorX& x, const VectorX& dx, const VectorX& ddx) override {
    VectorX::Map(data_->qpos, x.size()) = x;
    VectorX::Map(data_->qvel, dx.size()) = dx;
    VectorX::Map(data_->qacc, ddx.size()) = ddx;
    mj_kinematics(model_.get(), data_.get());
    mj_comPos(model_.get(), data_.get());
    mj_comVel(model_.get(), data_.get());
    mj_rne(model_.get(), data_.get(), 1, forces_.data());
    return forces_;
  }

  WorldWrench ground_wrench() override {
    mj_rnePostConstraint(model_.get(), data_.get());
    WorldWrench sum;
    for (int b = 1; b < model_->nbody; ++b) {
      if (model_->body_parentid[b] != 0) continue;
      const Vector3 moment = Vector3::Map(data_->cfrc_int + 6 * b), force = Vector3::Map(data_->cfrc_int + 6 * b + 3);
      sum.force += force;
      sum.moment += moment + Vector3::Map(data_->subtree_com + 3 * b).cross(force);
    }
    return sum;
  }

 protected:
  void body_pose(int body, Matrix3& rotation, Vector3& origin) override {
    rotation = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>::Map(data_->xmat + 9 * (body + 1));
    origin = Vector3::Map(data_->xpos + 3 * (body + 1));
  }
  void frame_jacobian(int body, const Vector3&, const Vector3& point, FrameMotion& motion) override {
    mj_jac(model_.get(), data_.get(), point_rows_.data(), rotation_rows_.data(), point.data(), body + 1);
    motion.point_jacobian = point_rows_;
    motion.rotation_jacobian = rotation_rows_;
  }

 private:
  std::unique_ptr<mjModel, Deleter> model_;
  std::unique_ptr<mjData, Deleter> data_;
  VectorX forces_;
  Samples point_rows_, rotation_rows_;
};

}  // namespace

PeerLibrary mujoco_library() {
  return {"MuJoCo", mj_versionString(), true,
          [](const RigidTree& tree) -> std::unique_ptr<Peer> { return std::make_unique<MujocoPeer>(tree); }};
}

}  // namespace balance::peers
