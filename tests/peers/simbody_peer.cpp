/// Simbody, with its own constraints for the cut joints: `calcResidualForceIgnoringConstraints` gives the forces of the
/// tree, `calcG` the constraints' Jacobian.

#include "peer.hpp"

#include <simbody/SimTKsimbody.h>

#include <algorithm>
#include <cmath>

namespace balance::peers {
namespace {

SimTK::Vec3 to_simbody(const Vector3& v) { return {v.x(), v.y(), v.z()}; }
SimTK::UnitVec3 to_direction(const Vector3& v) { return SimTK::UnitVec3(to_simbody(v)); }
Vector3 from_simbody(const SimTK::Vec3& v) { return {v[0], v[1], v[2]}; }

SimTK::Transform frame_with_axis(const ElementaryMotion& motion, const Vector3& position) {
  // pins turn about z, sliders move along x
  const SimTK::CoordinateAxis along =
      motion.is_rotation ? SimTK::CoordinateAxis(SimTK::ZAxis) : SimTK::CoordinateAxis(SimTK::XAxis);
  return {SimTK::Rotation(to_direction(motion.axis), along), to_simbody(position)};
}

SimTK::MassProperties mass_properties(const TreeBody& body) {
  const Vector3& c = body.com;
  const Matrix3 about_origin = body.inertia + body.mass * (c.squaredNorm() * Matrix3::Identity() - c * c.transpose());
  const Matrix3& i = about_origin;
  return {body.mass, to_simbody(c), SimTK::Inertia(i(0, 0), i(1, 1), i(2, 2), i(0, 1), i(0, 2), i(1, 2))};
}

class SimbodyPeer : public Peer {
 public:
  explicit SimbodyPeer(const RigidTree& tree) : matter_(system_), forces_(system_) {
    gravity_ = SimTK::Force::Gravity(forces_, matter_, to_simbody(tree.gravity));
    for (const TreeBody& body : tree.bodies) add(body);
    for (const CutJoint& cut : tree.cut_joints) add(cut);
    state_ = system_.realizeTopology();
    system_.realizeModel(state_);
    system_.realize(state_, SimTK::Stage::Instance);
    for (const SimTK::MobilizedBody& body : moved_) index_.push_back(body.getFirstUIndex(state_));
    accelerations_.resize(state_.getNU());
    tree_forces_.resize(tree.motion_count());
    jacobian_.setZero(state_.getNMultipliers(), tree.motion_count());
  }

  const VectorX& compute_tree_forces(const VectorX& x, const VectorX& dx, const VectorX& ddx) override {
    SimTK::Vector& q = state_.updQ();
    SimTK::Vector& u = state_.updU();
    for (std::size_t k = 0; k < index_.size(); ++k) {
      q[index_[k]] = x[k];  // pins and sliders have one coordinate, whose rate is their speed
      u[index_[k]] = dx[k];
      accelerations_[index_[k]] = ddx[k];
    }
    system_.realize(state_, SimTK::Stage::Velocity);
    matter_.calcResidualForceIgnoringConstraints(state_, no_forces_, gravity_.getBodyForces(state_), accelerations_,
                                                 residual_);
    for (std::size_t k = 0; k < index_.size(); ++k) tree_forces_[k] = residual_[index_[k]];
    return tree_forces_;
  }

  const MatrixX& compute_closure_jacobian() override {
    if (jacobian_.rows() == 0) return jacobian_;
    matter_.calcG(state_, g_);
    for (std::size_t k = 0; k < index_.size(); ++k)
      for (Eigen::Index row = 0; row < jacobian_.rows(); ++row)
        jacobian_(row, k) = g_(static_cast<int>(row), index_[k]);
    return jacobian_;
  }

  double closure_residual() override {
    double largest = 0;
    for (int row = 0; row < state_.getNQErr(); ++row) largest = std::max(largest, std::abs(state_.getQErr()[row]));
    return largest;
  }

  WorldWrench ground_wrench() override {
    SimTK::Vector_<SimTK::SpatialVec> motion;
    matter_.calcBodyAccelerationFromUDot(state_, accelerations_, motion);
    const SimTK::Vector_<SimTK::SpatialVec>& weights = gravity_.getBodyForces(state_);
    WorldWrench sum;
    for (SimTK::MobilizedBodyIndex b(1); b < matter_.getNumBodies(); ++b) {
      const SimTK::MobilizedBody& body = matter_.getMobilizedBody(b);
      const SimTK::SpatialVec wrench =
          body.getBodySpatialInertiaInGround(state_) * motion[b] + matter_.getGyroscopicForce(state_, b) - weights[b];
      const Vector3 force = from_simbody(wrench[1]);
      sum.force += force;
      sum.moment += from_simbody(wrench[0]) + from_simbody(body.getBodyOriginLocation(state_)).cross(force);
    }
    return sum;
  }

 private:
  SimTK::MobilizedBody& mobod(int body) {
    return body == tree_ground ? static_cast<SimTK::MobilizedBody&>(matter_.updGround())
                               : matter_.updMobilizedBody(bodies_[body]);
  }

  /// A body behind a chain of massless ones, one for each of its motions but the last.
  void add(const TreeBody& body) {
    SimTK::MobilizedBody parent = mobod(body.parent);
    Vector3 position = body.position;
    const SimTK::Body::Rigid last(mass_properties(body));
    const std::size_t count = body.motions.size();
    if (count == 0) parent = SimTK::MobilizedBody::Weld(parent, to_simbody(position), last, SimTK::Vec3(0));
    for (std::size_t k = 0; k < count; ++k) {
      const SimTK::Body carried = k + 1 == count ? SimTK::Body(last) : SimTK::Body(SimTK::Body::Massless());
      const SimTK::Transform on_parent = frame_with_axis(body.motions[k], position),
                             on_child = frame_with_axis(body.motions[k], Vector3::Zero());
      if (body.motions[k].is_rotation)
        parent = SimTK::MobilizedBody::Pin(parent, on_parent, carried, on_child);
      else
        parent = SimTK::MobilizedBody::Slider(parent, on_parent, carried, on_child);
      moved_.push_back(parent);
      position.setZero();
    }
    bodies_.push_back(parent.getMobilizedBodyIndex());
  }

  void add(const CutJoint& cut) {
    SimTK::MobilizedBody &a = mobod(cut.a.body), &b = mobod(cut.b.body);
    const auto alongs = std::count_if(cut.equations.begin(), cut.equations.end(),
                                      [](const ClosureEquation& equation) { return equation.is_along; });
    const bool shares_point = alongs == 3 || (alongs == 2 && cut.equations.size() == 2);  // in space, in the plane
    if (shares_point) SimTK::Constraint::Ball(a, to_simbody(cut.a.point), b, to_simbody(cut.b.point));
    for (const ClosureEquation& equation : cut.equations) {
      const Vector3 axis = cut.a.axes.col(equation.i);
      if (!equation.is_along)
        SimTK::Constraint::ConstantAngle(a, to_direction(axis), b, to_direction(cut.b.axes.col(equation.j)),
                                         SimTK::Pi / 2);
      else if (!shares_point)
        SimTK::Constraint::PointInPlane(a, to_direction(axis), axis.dot(cut.a.point), b, to_simbody(cut.b.point));
    }
  }

  SimTK::MultibodySystem system_;
  SimTK::SimbodyMatterSubsystem matter_;
  SimTK::GeneralForceSubsystem forces_;
  SimTK::Force::Gravity gravity_;
  SimTK::State state_;
  std::vector<SimTK::MobilizedBodyIndex> bodies_;
  std::vector<SimTK::MobilizedBody> moved_;
  std::vector<int> index_;
  SimTK::Vector accelerations_, residual_, no_forces_;
  SimTK::Matrix g_;
  VectorX tree_forces_;
  MatrixX jacobian_;
};

std::string simbody_version() {
  int major = 0, minor = 0, patch = 0;
  SimTK_version_simbody(&major, &minor, &patch);
  return std::to_string(major) + "." + std::to_string(minor) + "." + std::to_string(patch);
}

}  // namespace

PeerLibrary simbody_library() {
  return {"Simbody", simbody_version(), true,
          [](const RigidTree& tree) -> std::unique_ptr<Peer> { return std::make_unique<SimbodyPeer>(tree); }};
}

}  // namespace balance::peers
