/// MuJoCo. Its equality constraints are soft springs without an exact inverse, so loops are closed by the Jacobians of
/// the cut joints' points (`mj_jac`), and `mj_rne` gives the forces of the tree.

#include "jacobian_peer.hpp"

#include <mujoco/mujoco.h>

#include <fmt/format.h>

#include <cstring>
#include <memory>
#include <stdexcept>

namespace balance::peers {
namespace {

/// MuJoCo takes no moving body without mass; this much is far below round-off.
constexpr double min_mass = 2e-15;

std::string numbers(const Vector3& v) { return fmt::format("{:.17g} {:.17g} {:.17g}", v.x(), v.y(), v.z()); }

std::string format_inertial(const TreeBody& body) {
  const Matrix3& inertia = body.inertia;
  return fmt::format("<inertial pos='{}' mass='{:.17g}' fullinertia='{} {}'/>\n", numbers(body.com), body.mass,
                     numbers(inertia.diagonal()), numbers({inertia(0, 1), inertia(0, 2), inertia(1, 2)}));
}

std::string format_children(const RigidTree& tree, int parent) {
  std::string text;
  for (int b = parent + 1; b < static_cast<int>(tree.bodies.size()); ++b) {
    const TreeBody& body = tree.bodies[b];
    if (body.parent != parent) continue;
    text += fmt::format("<body pos='{}'>\n", numbers(body.position));
    for (const ElementaryMotion& motion : body.motions)
      text += fmt::format("<joint type='{}' axis='{}'/>\n", motion.is_rotation ? "hinge" : "slide",
                          numbers(motion.axis));
    text += format_inertial(body) + format_children(tree, b) + "</body>\n";
  }
  return text;
}

std::string format_mjcf(const RigidTree& tree) {
  return fmt::format(
      "<mujoco><compiler angle='radian' boundmass='{0}' boundinertia='{0}'/><option gravity='{1}'/>\n"
      "<worldbody>\n{2}</worldbody></mujoco>\n",
      min_mass, numbers(tree.gravity), format_children(tree, tree_ground));
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
