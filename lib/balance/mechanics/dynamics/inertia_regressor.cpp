#include "balance/mechanics/dynamics/inertia_regressor.hpp"

namespace balance::dynamics {

using kinematics::Tree;

template <>
VectorX list_inertial_parameters<kinematics::Planar>(const kinematics::Planar::Inertia& inertia) {
  return Eigen::Vector4d(inertia.mass, inertia.first_moment.x(), inertia.first_moment.y(), inertia.second_moment);
}

template <>
VectorX list_inertial_parameters<kinematics::Spatial>(const kinematics::Spatial::Inertia& inertia) {
  VectorX pi(10);
  const Matrix3& I = inertia.second_moment;
  pi << inertia.mass, inertia.first_moment, I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2);
  return pi;
}

template <class S>
VectorX list_inertial_parameters(const Tree<S>& tree) {
  VectorX parameters(S::inertial_parameter_count * static_cast<Eigen::Index>(tree.mass_elements.size()));
  for (std::size_t e = 0; e < tree.mass_elements.size(); ++e)
    parameters.segment(static_cast<Eigen::Index>(e) * S::inertial_parameter_count, S::inertial_parameter_count) =
        list_inertial_parameters<S>(tree.mass_elements[e].inertia);
  return parameters;
}

namespace {

/// The inertia with parameter k equal to one and all others zero.
template <class S>
typename S::Inertia unit_inertia(int k);

template <>
kinematics::Planar::Inertia unit_inertia<kinematics::Planar>(int k) {
  return {k == 0 ? 1.0 : 0, Vector2(k == 1, k == 2), k == 3 ? 1.0 : 0};
}

template <>
kinematics::Spatial::Inertia unit_inertia<kinematics::Spatial>(int k) {
  static constexpr int tensor_entries[6][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {0, 2}, {1, 2}};
  kinematics::Spatial::Inertia inertia;
  inertia.mass = k == 0;
  inertia.first_moment = Vector3(k == 1, k == 2, k == 3);
  if (k > 3) {
    const auto [row, column] = tensor_entries[k - 4];
    inertia.second_moment(row, column) = inertia.second_moment(column, row) = 1;
  }
  return inertia;
}

/// Motion of a frame fixed to a node, in the frame's axes; R_PN and p_PN are its pose relative to the node.
template <class S>
kinematics::NodeState<S> compute_frame_motion(const kinematics::NodeState<S>& node,
                                              const kinematics::FixedFrame<S>& frame) {
  kinematics::NodeState<S> s;
  s.R_PN = frame.R_N;
  s.p_PN = frame.p_N;
  s.angular_velocity = rotate_inverse(frame.R_N, node.angular_velocity);
  s.angular_acceleration = rotate_inverse(frame.R_N, node.angular_acceleration);
  s.acceleration_operator = kinematics::make_acceleration_operator(s.angular_velocity, s.angular_acceleration);
  s.acceleration = rotate_inverse(frame.R_N, local_point_acceleration(node, frame.p_N));
  return s;
}

}  // namespace

template <class S>
InertiaRegressor<S> compute_regressor(const Tree<S>& tree, const kinematics::TreeState<S>& state) {
  const Eigen::Index P = S::inertial_parameter_count * static_cast<Eigen::Index>(tree.mass_elements.size());
  InertiaRegressor<S> out{MatrixX::Zero(tree.columns, P), MatrixX::Zero(S::dimension, P),
                          MatrixX::Zero(S::angular_dimension, P)};
  for (std::size_t e = 0; e < tree.mass_elements.size(); ++e) {
    const kinematics::FixedFrame<S>& frame = tree.mass_elements[e].frame;
    if (frame.node == 0) continue;
    const kinematics::NodeState<S> s = compute_frame_motion(state[frame.node], frame);
    for (int k = 0; k < S::inertial_parameter_count; ++k) {
      const Eigen::Index column = static_cast<Eigen::Index>(e) * S::inertial_parameter_count + k;
      Wrench<S> element_wrench, wrench;
      add_inertia_wrench<S>(unit_inertia<S>(k), s, element_wrench);
      propagate_to_parent(s, element_wrench, wrench);
      for (kinematics::NodeId n = frame.node; n > 0; n = tree.nodes[n].parent) {
        const kinematics::Node<S>& node = tree.nodes[n];
        if (node.motion != kinematics::NodeMotion::weld)
          out.torque(node.column, column) += project_on_joint_axis(node, wrench);
        Wrench<S> parent_wrench;
        propagate_to_parent(state[n], wrench, parent_wrench);
        wrench = parent_wrench;
      }
      for (int i = 0; i < S::dimension; ++i) out.force(i, column) = wrench.force[i];
      const Vector3 moment = kinematics::angular_to_3d(wrench.moment);
      for (int i = 0; i < S::angular_dimension; ++i) out.moment(i, column) = moment[S::angular_dimension == 1 ? 2 : i];
    }
  }
  return out;
}

template <class S>
UnitWrenches<S> compute_unit_wrenches(const Tree<S>& tree, const kinematics::TreeState<S>& state) {
  std::vector<Wrench<S>> wrenches(static_cast<std::size_t>(S::inertial_parameter_count) * tree.mass_elements.size());
  for (std::size_t e = 0; e < tree.mass_elements.size(); ++e) {
    const kinematics::FixedFrame<S>& frame = tree.mass_elements[e].frame;
    if (frame.node == 0) continue;
    const kinematics::NodeState<S> s = compute_frame_motion(state[frame.node], frame);
    for (int k = 0; k < S::inertial_parameter_count; ++k) {
      Wrench<S> element_wrench;
      add_inertia_wrench<S>(unit_inertia<S>(k), s, element_wrench);
      propagate_to_parent(s, element_wrench, wrenches[e * S::inertial_parameter_count + static_cast<std::size_t>(k)]);
    }
  }
  return wrenches;
}

template <class S>
InertiaRegressor<S> compute_momentum_rate_regressor(const Tree<S>& tree, const kinematics::TreeState<S>& state) {
  const Eigen::Index P = S::inertial_parameter_count * static_cast<Eigen::Index>(tree.mass_elements.size());
  InertiaRegressor<S> out{MatrixX(0, P), MatrixX::Zero(S::dimension, P), MatrixX::Zero(S::angular_dimension, P)};
  for (std::size_t e = 0; e < tree.mass_elements.size(); ++e) {
    const kinematics::FixedFrame<S>& frame = tree.mass_elements[e].frame;
    if (frame.node == 0) continue;
    const kinematics::NodeState<S> s = compute_frame_motion(state[frame.node], frame);
    kinematics::NodeState<S> world_frame;  // pose of the element's frame in the world
    world_frame.R_PN = state[frame.node].R_WN * frame.R_N;
    world_frame.p_PN = position(state, frame);
    for (int k = 0; k < S::inertial_parameter_count; ++k) {
      Wrench<S> element_wrench, wrench;
      add_inertia_wrench<S>(unit_inertia<S>(k), s, element_wrench);
      propagate_to_parent(world_frame, element_wrench, wrench);
      const Eigen::Index column = static_cast<Eigen::Index>(e) * S::inertial_parameter_count + k;
      for (int i = 0; i < S::dimension; ++i) out.force(i, column) = wrench.force[i];
      const Vector3 moment = kinematics::angular_to_3d(wrench.moment);
      for (int i = 0; i < S::angular_dimension; ++i) out.moment(i, column) = moment[S::angular_dimension == 1 ? 2 : i];
    }
  }
  return out;
}

#define BALANCE_INSTANTIATE(S)                                                                                      \
  template VectorX list_inertial_parameters<S>(const Tree<S>&);                                                     \
  template UnitWrenches<S> compute_unit_wrenches<S>(const Tree<S>&, const kinematics::TreeState<S>&);               \
  template InertiaRegressor<S> compute_momentum_rate_regressor<S>(const Tree<S>&, const kinematics::TreeState<S>&); \
  template InertiaRegressor<S> compute_regressor<S>(const Tree<S>&, const kinematics::TreeState<S>&);
BALANCE_INSTANTIATE(kinematics::Planar)
BALANCE_INSTANTIATE(kinematics::Spatial)
#undef BALANCE_INSTANTIATE

}  // namespace balance::dynamics
