// What springs ask of the actuators at rest.

#include "balance/conditions/rows.hpp"

namespace balance {

/// Generalised forces that hold the springs, per unit of each of their parameters: ∂U/∂y with U linear in k, k a, k b, k a bᵀ; in
/// joint coordinates in k and the preload.
template <class S>
MatrixX GoalRows<S>::spring_torques() {
  MatrixX torque = MatrixX::Zero(tree_.columns, parameters_ - inertial_ - known_.size());
  VectorX unit = VectorX::Zero(tree_.columns);
  for (int c = 0; c < tree_.columns; ++c) {
    unit.setZero();
    unit[c] = 1;
    compute_velocities(tree_, unit.data(), state_);
    Eigen::Index at = 0;
    for (std::size_t s = 0; s < mechanism_.springs.size(); ++s) {
      const Spring& spring = mechanism_.springs[s];
      if (spring.is_joint_spring()) {  // k q − preload
        const LinearQuantity& source = tree_.coordinate_expressions[static_cast<std::size_t>(spring.coordinate)];
        const double ratio = source.rate(unit.data());
        torque(c, at++) = ratio * source.value(y_.data());
        torque(c, at++) = -ratio;
        continue;
      }
      const FixedFrame<S>&A = tree_.bodies[static_cast<std::size_t>(spring.first)],
            &B = tree_.bodies[static_cast<std::size_t>(spring.second)];
      const NodeState<S>&a = state_[static_cast<std::size_t>(A.node)], &b = state_[static_cast<std::size_t>(B.node)];
      const bool loose = s < options_.loose_springs.size() && options_.loose_springs[s];
      const typename S::Vector end_a = loose ? typename S::Vector(S::Vector::Zero()) : to_vector<S>(spring.point_first);
      const typename S::Vector end_b =
          loose ? typename S::Vector(S::Vector::Zero()) : to_vector<S>(spring.point_second);
      const typename S::Vector p_A = A.p_N + A.R_N * end_a, p_B = B.p_N + B.R_N * end_b;
      const typename S::Vector d = position(state_, {A.node, A.R_N, p_A}) - position(state_, {B.node, B.R_N, p_B});
      const typename S::Vector rate = point_velocity<S>(a, p_A) - point_velocity<S>(b, p_B);
      const double length = d.norm();
      const bool taut = loose || spring.free_length == 0;
      torque(c, at++) = d.dot(rate) * (taut ? 1 : length > 0 ? 1 - spring.free_length / length : 0);
      if (!loose) continue;
      const typename S::Rotation R_A = a.R_WN * A.R_N, R_B = b.R_WN * B.R_N;
      const typename S::Angular w_A = a.R_WN * a.angular_velocity, w_B = b.R_WN * b.angular_velocity;
      const auto turned_rate = [](const typename S::Angular& w, const typename S::Vector& e) {
        return typename S::Vector(cross(w, e));
      };
      for (int i = 0; i < S::dimension; ++i)
        torque(c, at++) = rate.dot(axis(R_A, i)) + d.dot(turned_rate(w_A, axis(R_A, i)));
      for (int j = 0; j < S::dimension; ++j)
        torque(c, at++) = -rate.dot(axis(R_B, j)) - d.dot(turned_rate(w_B, axis(R_B, j)));
      for (int i = 0; i < S::dimension; ++i)
        for (int j = 0; j < S::dimension; ++j)
          torque(c, at++) =
              -turned_rate(w_A, axis(R_A, i)).dot(axis(R_B, j)) - axis(R_A, i).dot(turned_rate(w_B, axis(R_B, j)));
    }
  }
  return torque;
}

template MatrixX GoalRows<Planar>::spring_torques();
template MatrixX GoalRows<Spatial>::spring_torques();

}  // namespace balance
