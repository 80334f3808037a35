#pragma once
/// Generalised forces of a mechanism and of its chains moving along with it, by the regressor alone.

#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/mechanics/dynamics/inertia_regressor.hpp"
#include "balance/mechanics/kinematics/closure.hpp"
#include "balance/mechanics/kinematics/joint_coordinates.hpp"
#include "balance/synthesis/conditions/chain_split.hpp"
#include "balance/synthesis/conditions/configuration_sampler.hpp"

#include <map>
#include <string>

namespace hand_made {

using namespace balance;
using namespace balance::conditions;

/// One joint coordinate's motion and how it changes with the independent velocities.
struct JointMotion {
  double position = 0, velocity = 0, acceleration = 0;
  VectorX rates;
};

/// A mechanism at random states.
template <class S>
class Moving {
 public:
  Moving(const Mechanism& mechanism, std::uint64_t seed)
      : m_(mechanism),
        tree_(kinematics::compile_tree<S>(mechanism, mechanism.actuators)),
        sampler_(mechanism, tree_, seed),
        random_(seed),
        state_(tree_.nodes.size()) {}

  bool next() {
    SampledConfiguration at;
    if (!sampler_.next(at)) return false;
    y_ = at.y;
    const VectorX scale = column_scale(tree_);
    directions_ = scale.asDiagonal() * at.null_space;
    compute_poses(tree_, y_.data(), state_);
    dy_ = directions_ * random_.sample_normal(directions_.cols());
    ddy_ = directions_ * random_.sample_normal(directions_.cols()) + bias(scale);
    return true;
  }

  /// Forces along the independent velocities, per unit of every inertial parameter.
  /// @param moving 0: the velocities are left out, the accelerations kept
  MatrixX forces(double moving, const Vector3& gravity) {
    return directions_.transpose() * torque(tree_, state_, y_, moving * dy_, ddy_, gravity);
  }

  std::map<std::string, JointMotion> joints() {
    std::map<std::string, JointMotion> out;
    read(dy_, ddy_, [&](const std::string& name, double q, double dq, double ddq) {
      out[name] = {q, dq, ddq, VectorX(directions_.cols())};
    });
    for (Eigen::Index k = 0; k < directions_.cols(); ++k)
      read(directions_.col(k), VectorX::Zero(tree_.columns),
           [&](const std::string& name, double, double dq, double) { out[name].rates[k] = dq; });
    return out;
  }

  /// Forces of a chain whose joints move like these, along the whole mechanism's independent velocities.
  MatrixX chain_forces(const Chain& chain, double moving, const Vector3& gravity) {
    const kinematics::Tree<S> tree = kinematics::compile_tree<S>(chain.mechanism, {});
    kinematics::TreeState<S> state(tree.nodes.size());
    VectorX y(tree.columns), dy(tree.columns), ddy(tree.columns);
    MatrixX rates(tree.columns, directions_.cols());
    const auto motions = joints();
    for (std::size_t c = 0; c < tree.coordinate_expressions.size(); ++c) {
      const kinematics::LinearQuantity& source = tree.coordinate_expressions[c];
      if (!source.has_single_term()) continue;
      const auto& [column, ratio] = source.terms[0];
      const JointMotion& motion = motions.at(chain.mechanism.coordinates[c].name);
      y[column] = (motion.position - source.constant) / ratio;
      dy[column] = moving * motion.velocity / ratio;
      ddy[column] = motion.acceleration / ratio;
      rates.row(column) = motion.rates.transpose() / ratio;
    }
    return rates.transpose() * torque(tree, state, y, dy, ddy, gravity);
  }

 private:
  static MatrixX torque(const kinematics::Tree<S>& tree, kinematics::TreeState<S>& state, const VectorX& y,
                        const VectorX& dy, const VectorX& ddy, const Vector3& gravity) {
    compute_poses(tree, y.data(), state);
    compute_angular_velocities(tree, dy.data(), state);
    compute_accelerations(tree, dy.data(), ddy.data(), typename S::Vector(-kinematics::to_vector<S>(gravity)), state);
    return dynamics::compute_regressor(tree, state).torque;
  }

  template <class Take>
  void read(const VectorX& dy, const VectorX& ddy, const Take& take) {
    compute_poses(tree_, y_.data(), state_);
    compute_velocities(tree_, dy.data(), state_);
    kinematics::compute_accelerations<S>(tree_, dy.data(), ddy.data(), S::Vector::Zero(), state_);
    for (const Coordinate& coordinate : m_.coordinates) {
      const Joint& joint = m_.joints[static_cast<std::size_t>(coordinate.joint)];
      const auto r = compute_joint_motion(joint, relative_motion(tree_, state_, joint));
      const auto i = static_cast<std::size_t>(coordinate.index);
      take(coordinate.name, r.position[i], r.velocity[i], r.acceleration[i]);
    }
  }

  /// Accelerations that the loops demand at this velocity.
  VectorX bias(const VectorX& scale) {
    if (tree_.closure_rows == 0) return VectorX::Zero(tree_.columns);
    compute_velocities(tree_, dy_.data(), state_);
    kinematics::compute_accelerations<S>(tree_, dy_.data(), nullptr, S::Vector::Zero(), state_);
    VectorX demand(tree_.closure_rows), residual;
    double* next = demand.data();
    for (const kinematics::Closure<S>& closure : tree_.closures) {
      closure_bias(state_, closure, closure_pose(state_, closure), next);
      for (const kinematics::ClosureRow& row : closure.rows)
        *next++ *= row.kind == kinematics::ClosureRow::Kind::along ? -1 / tree_.characteristic_length : -1;
    }
    kinematics::ConstraintSystem<S> system(tree_, kinematics::Drive<S>{});
    MatrixX jacobian;
    system.evaluate(y_, {}, residual, jacobian);
    Eigen::CompleteOrthogonalDecomposition<MatrixX> qr;
    qr.setThreshold(1e-9);
    return scale.cwiseProduct(VectorX(qr.compute(jacobian).solve(demand)));
  }

  const Mechanism m_;
  kinematics::Tree<S> tree_;
  ConfigurationSampler<S> sampler_;
  numerics::UniformRandom random_;
  kinematics::TreeState<S> state_;
  VectorX y_, dy_, ddy_;
  MatrixX directions_;  ///< columns × freedoms
};

}  // namespace hand_made
