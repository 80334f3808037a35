#pragma once
/// The prescribed quantities as equations in the tree coordinates: tool position, centre of mass, quantities linear in
/// y (joint coordinates, the angle of a planar tool), rotation of a spatial tool.

#include "balance/foundation/base/rotation.hpp"
#include "balance/mechanics/kinematics/closure.hpp"
#include "balance/mechanics/trajectory/drive_sample.hpp"

#include <vector>

namespace balance::kinematics {

/// The quantities with prescribed values. Order of the rows: point, com, linear (one value each), rotation.
template <class S>
struct Drive {
  std::vector<int> point;  ///< world components of the tool point
  std::vector<int> com;    ///< world components of the centre of mass
  std::vector<LinearQuantityOf<typename S::Scalar>> linear;
  std::vector<int> rotation;      ///< spatial: world components of the tool's rotation
  FixedFrame<S> tool;             ///< tool point with the axes of its body
  std::vector<NodeId> tool_path;  ///< nodes that move the tool

  int value_count() const { return static_cast<int>(point.size() + com.size() + linear.size()); }
  int row_count() const { return value_count() + static_cast<int>(rotation.size()); }
};

/// Mass carried by each node, and its first moment in world axes about the world's origin.
template <class S>
struct MassDistribution {
  std::vector<typename Constants<S>::Scalar> mass;  ///< of the node and all nodes it carries
  std::vector<typename S::Vector> moment;           ///< Σ m r

  explicit MassDistribution(const Tree<Constants<S>>& tree) : mass(tree.nodes.size(), 0), moment(tree.nodes.size()) {
    for (std::size_t n = tree.nodes.size(); n-- > 1;) {
      mass[n] += tree.nodes[n].inertia.mass;
      mass[tree.nodes[n].parent] += mass[n];
    }
  }

  void update(const Tree<Constants<S>>& tree, const TreeState<S>& state) {
    for (auto& m : moment) m.setZero();
    for (std::size_t n = tree.nodes.size(); n-- > 1;) {
      const auto& inertia = tree.nodes[n].inertia;
      moment[n] += state[n].R_WN * inertia.first_moment + inertia.mass * state[n].p_WN;
      moment[tree.nodes[n].parent] += moment[n];
    }
  }

  typename S::Vector com() const { return mass[0] > 0 ? typename S::Vector(moment[0] / mass[0]) : S::Vector::Zero(); }

  /// Change of the CoM's position per unit of the node's coordinate.
  typename S::Vector com_gradient(const Node<Constants<S>>& node, const NodeState<S>& state, int n) const {
    if (node.motion == NodeMotion::prismatic) return node.ratio * mass[n] / mass[0] * prismatic_axis(state.R_WN);
    const auto e = revolute_axis(state.R_WN);
    return node.ratio / mass[0] * typename S::Vector(cross(e, typename S::Vector(moment[n] - mass[n] * state.p_WN)));
  }
};

/// Deviation of a tool's rotation R from the prescribed T: ½ Σ T axis × R axis, the sine of the rotation error as a
/// vector in world axes. Its rate is A ω − Aᵀ ω_T. A is the identity at R = T, which need not hold if only some
/// components of the rotation are prescribed.
template <class N>
struct RotationResidual {
  Vector3Of<N> residual;
  Matrix3Of<N> jacobian;  ///< ½ (tr(R Tᵀ) E − R Tᵀ)

  RotationResidual(const Matrix3Of<N>& T, const Matrix3Of<N>& R) {
    const Matrix3Of<N> M = R * T.transpose();
    residual = 0.5 * Vector3Of<N>(M(2, 1) - M(1, 2), M(0, 2) - M(2, 0), M(1, 0) - M(0, 1));
    jacobian = 0.5 * (M.trace() * Matrix3Of<N>::Identity() - M);
  }
};

/// The same for a search from far away: twice the vector part of the error's quaternion, which unlike the sine does not
/// vanish again at half a turn. Its rate for constant T is B ω.
struct QuaternionError {
  Vector3 error;
  Matrix3 jacobian;

  QuaternionError(const Matrix3& T, const Matrix3& R) {
    const Eigen::Vector4d q = quaternion_of(R * T.transpose());
    error = 2 * q.tail<3>();
    jacobian = q[0] * Matrix3::Identity() - skew(q.tail<3>());
  }
};

/// dA/dt of RotationResidual.
template <class N>
Matrix3Of<N> compute_rotation_jacobian_rate(const Matrix3Of<N>& T, const Vector3Of<N>& w_T, const Matrix3Of<N>& R,
                                            const Vector3Of<N>& w) {
  const Matrix3Of<N> M = R * T.transpose();
  const Matrix3Of<N> rate = skew(w) * M - M * skew(w_T);
  return 0.5 * (rate.trace() * Matrix3Of<N>::Identity() - rate);
}

/// Present values of the driven quantities, with zero rates. State: poses at y.
template <class S>
trajectory::DriveSampleOf<typename S::Scalar> measure_drive(const Tree<Constants<S>>& tree,
                                                            const Drive<Constants<S>>& drive, const TreeState<S>& state,
                                                            const typename S::Scalar* y) {
  trajectory::DriveSampleOf<typename S::Scalar> sample;
  sample.value.resize(drive.value_count());
  int k = 0;
  for (const int component : drive.point) sample.value[k++] = position(state, drive.tool)[component];
  if (!drive.com.empty()) {
    MassDistribution<S> masses(tree);
    masses.update(tree, state);
    for (const int component : drive.com) sample.value[k++] = masses.com()[component];
  }
  for (const auto& quantity : drive.linear) sample.value[k++] = quantity.value(y);
  sample.rotation = to_matrix(orientation(state, drive.tool));
  sample.rate.setZero(drive.value_count());
  sample.acceleration.setZero(drive.value_count());
  return sample;
}

/// Acceleration of the centre of mass for the accelerations in the state (world axes).
template <class S>
typename S::Vector com_acceleration(const Tree<Constants<S>>& tree, const TreeState<S>& state) {
  typename S::Vector force = S::Vector::Zero();
  for (std::size_t n = 1; n < tree.nodes.size(); ++n) {
    const Node<Constants<S>>& node = tree.nodes[n];
    const NodeState<S>& s = state[n];
    if (node.massless) continue;
    force += s.R_WN * inertia_force<S>(node.inertia, s);
  }
  return force / tree.mass;
}

template <class S>
typename S::Vector com_velocity(const Tree<Constants<S>>& tree, const TreeState<S>& state) {
  typename S::Vector momentum = S::Vector::Zero();
  for (std::size_t n = 1; n < tree.nodes.size(); ++n) {
    const NodeState<S>& s = state[n];
    const auto& inertia = tree.nodes[n].inertia;
    momentum +=
        s.R_WN * typename S::Vector(inertia.mass * s.velocity + cross(s.angular_velocity, inertia.first_moment));
  }
  return momentum / tree.mass;
}

}  // namespace balance::kinematics
