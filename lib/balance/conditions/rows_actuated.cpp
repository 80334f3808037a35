// Velocities and accelerations in terms of the actuators' own.

#include "balance/base/factorizations.hpp"
#include "balance/conditions/rows.hpp"
#include "balance/kinematics/closure.hpp"

namespace balance {

namespace {

/// Smallest singular value of the actuated rows of the null space: below it C is large and the rows are ill-conditioned.
constexpr double min_actuator_regularity = 0.02;

}  // namespace

/// C = N (S N)⁻¹: its actuated rows are the identity.
template <class S>
bool GoalRows<S>::set_actuated(const MatrixX& null_space) {
  const MatrixX held = selection_ * null_space;
  if (held.rows() != held.cols()) return false;
  if (held.size() > 0 && singular_values(held).tail(1)[0] < min_actuator_regularity) return false;
  actuated_ = null_space * held.partialPivLu().inverse();
  return true;
}

/// The accelerations that a velocity causes while the actuators' own are zero.
template <class S>
VectorX GoalRows<S>::actuated_bias(const VectorX& velocity) {
  const VectorX dy = scale_.cwiseProduct(velocity);
  compute_velocities(tree_, dy.data(), state_);
  compute_accelerations<S>(tree_, dy.data(), nullptr, S::Vector::Zero(), state_);
  const Eigen::Index closures = tree_.closure_rows, actuated = selection_.rows();
  VectorX bias = VectorX::Zero(closures + actuated);
  ConstraintSystem<S> system(tree_, Drive<S>{});
  MatrixX jacobian;
  system.velocity_jacobian(y_, {}, jacobian);
  double* next = bias.data();
  for (const Closure<S>& closure : tree_.closures) {
    closure_bias(state_, closure, closure_pose(state_, closure), next);
    for (const ClosureRow& row : closure.rows) *next++ *= -compute_row_scale(tree_, closure, row);
  }
  MatrixX all(closures + actuated, tree_.columns);
  all << jacobian, selection_;
  CompleteOrthogonalDecomposition qr;
  qr.setThreshold(1e-9);  // redundant closures have rows of round-off
  return qr.compute(all).solve(bias);
}

#define BALANCE_INSTANTIATE(S)                             \
  template bool GoalRows<S>::set_actuated(const MatrixX&); \
  template VectorX GoalRows<S>::actuated_bias(const VectorX&);
BALANCE_INSTANTIATE(Planar)
BALANCE_INSTANTIATE(Spatial)
#undef BALANCE_INSTANTIATE

}  // namespace balance
