#include "balance/dynamics/regressor.hpp"

namespace balance {

template <>
VectorX parameters_of<Planar>(const Planar::Inertia& inertia) {
  return Eigen::Vector4d(inertia.mass, inertia.moment.x(), inertia.moment.y(), inertia.second);
}

template <>
VectorX parameters_of<Spatial>(const Spatial::Inertia& inertia) {
  VectorX pi(10);
  const Matrix3& I = inertia.second;
  pi << inertia.mass, inertia.moment, I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2);
  return pi;
}

template <class S>
VectorX parameters_of(const Tree<S>& tree) {
  VectorX all(S::parameters * static_cast<Eigen::Index>(tree.elements.size()));
  for (std::size_t e = 0; e < tree.elements.size(); ++e)
    all.segment(static_cast<Eigen::Index>(e) * S::parameters, S::parameters) =
        parameters_of<S>(tree.elements[e].inertia);
  return all;
}

namespace {

/// The inertia with parameter k equal to one and all others zero.
template <class S>
typename S::Inertia unit_inertia(int k);

template <>
Planar::Inertia unit_inertia<Planar>(int k) {
  return {k == 0 ? 1.0 : 0, Vector2(k == 1, k == 2), k == 3 ? 1.0 : 0};
}

template <>
Spatial::Inertia unit_inertia<Spatial>(int k) {
  static constexpr int place[6][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {0, 2}, {1, 2}};
  Spatial::Inertia inertia;
  inertia.mass = k == 0;
  inertia.moment = Vector3(k == 1, k == 2, k == 3);
  if (k > 3) {
    const auto [row, column] = place[k - 4];
    inertia.second(row, column) = inertia.second(column, row) = 1;
  }
  return inertia;
}

/// Motion of a frame fixed to a node, in the frame's axes; R_PN and p_PN lead back to the node.
template <class S>
NodeState<S> motion_of(const NodeState<S>& node, const FixedFrame<S>& frame) {
  NodeState<S> s;
  s.R_PN = frame.R_N;
  s.p_PN = frame.p_N;
  s.angular_velocity = unrotate(frame.R_N, node.angular_velocity);
  s.angular_acceleration = unrotate(frame.R_N, node.angular_acceleration);
  s.turning = turning(s.angular_velocity, s.angular_acceleration);
  s.acceleration = unrotate(frame.R_N, own_acceleration(node, frame.p_N));
  return s;
}

}  // namespace

template <class S>
Regressor<S> regressor(const Tree<S>& tree, const State<S>& state) {
  const Eigen::Index P = S::parameters * static_cast<Eigen::Index>(tree.elements.size());
  Regressor<S> out{MatrixX::Zero(tree.columns, P), MatrixX::Zero(S::dimension, P), MatrixX::Zero(S::angular, P)};
  for (std::size_t e = 0; e < tree.elements.size(); ++e) {
    const FixedFrame<S>& frame = tree.elements[e].frame;
    if (frame.node == 0) continue;
    const NodeState<S> s = motion_of(state[frame.node], frame);
    for (int k = 0; k < S::parameters; ++k) {
      const Eigen::Index column = static_cast<Eigen::Index>(e) * S::parameters + k;
      Wrench<S> own, here;
      add_inertia_wrench<S>(unit_inertia<S>(k), s, own);
      pass_on(s, own, here);
      for (NodeId n = frame.node; n > 0; n = tree.nodes[n].parent) {
        const Node<S>& node = tree.nodes[n];
        if (node.motion != NodeMotion::weld) out.torque(node.column, column) += along_motion(node, here);
        Wrench<S> below;
        pass_on(state[n], here, below);
        here = below;
      }
      for (int i = 0; i < S::dimension; ++i) out.force(i, column) = here.force[i];
      const Vector3 moment = angular_to_3d(here.moment);
      for (int i = 0; i < S::angular; ++i) out.moment(i, column) = moment[S::angular == 1 ? 2 : i];
    }
  }
  return out;
}

template <class S>
Regressor<S> ground_regressor(const Tree<S>& tree, const State<S>& state) {
  const Eigen::Index P = S::parameters * static_cast<Eigen::Index>(tree.elements.size());
  Regressor<S> out{MatrixX(0, P), MatrixX::Zero(S::dimension, P), MatrixX::Zero(S::angular, P)};
  for (std::size_t e = 0; e < tree.elements.size(); ++e) {
    const FixedFrame<S>& frame = tree.elements[e].frame;
    if (frame.node == 0) continue;
    const NodeState<S> s = motion_of(state[frame.node], frame);
    NodeState<S> place;  // of the element's frame in the world
    place.R_PN = state[frame.node].R_WN * frame.R_N;
    place.p_PN = position(state, frame);
    for (int k = 0; k < S::parameters; ++k) {
      Wrench<S> own, here;
      add_inertia_wrench<S>(unit_inertia<S>(k), s, own);
      pass_on(place, own, here);
      const Eigen::Index column = static_cast<Eigen::Index>(e) * S::parameters + k;
      for (int i = 0; i < S::dimension; ++i) out.force(i, column) = here.force[i];
      const Vector3 moment = angular_to_3d(here.moment);
      for (int i = 0; i < S::angular; ++i) out.moment(i, column) = moment[S::angular == 1 ? 2 : i];
    }
  }
  return out;
}

#define BALANCE_INSTANTIATE(S)                                                \
  template VectorX parameters_of<S>(const Tree<S>&);                          \
  template Regressor<S> ground_regressor<S>(const Tree<S>&, const State<S>&); \
  template Regressor<S> regressor<S>(const Tree<S>&, const State<S>&);
BALANCE_INSTANTIATE(Planar)
BALANCE_INSTANTIATE(Spatial)
#undef BALANCE_INSTANTIATE

}  // namespace balance
