#include "balance/conditions/known_columns.hpp"

#include <cmath>

namespace balance {

namespace {

/// Components of a load: force, then moment.
template <class S>
constexpr int load_components = S::dimension + S::angular_dimension;

}  // namespace

template <class S>
KnownTermColumns<S>::KnownTermColumns(const Mechanism& mechanism, const Tree<S>& tree)
    : mechanism_(mechanism), tree_(tree), terms_(list_known_terms(mechanism)) {
  if (const MatrixX changes = load_changes(mechanism, tree.characteristic_length); !changes.isZero(0))
    changes_ = changes;
}

/// What holds every unit component of every load: less its power at unit rates of the coordinates.
template <class S>
MatrixX KnownTermColumns<S>::load_torques(TreeState<S>& state) const {
  constexpr int size = load_components<S>;
  MatrixX torque(tree_.columns, size * static_cast<Eigen::Index>(mechanism_.loads.size()));
  VectorX unit = VectorX::Zero(tree_.columns);
  for (int c = 0; c < tree_.columns; ++c) {
    unit.setZero();
    unit[c] = 1;
    compute_velocities(tree_, unit.data(), state);
    Eigen::Index at = 0;
    for (const Load& load : mechanism_.loads) {
      const FixedFrame<S>& body = tree_.bodies[static_cast<std::size_t>(load.body)];
      const NodeState<S>& node = state[static_cast<std::size_t>(body.node)];
      typename S::Vector rate =
          point_velocity<S>(node, typename S::Vector(body.p_N + body.R_N * to_vector<S>(load.point)));
      typename S::Angular turn = node.R_WN * node.angular_velocity;
      if (load.frame == Frame::body) {
        const typename S::Rotation R = node.R_WN * body.R_N;
        rate = rotate_inverse(R, rate);
        turn = rotate_inverse(R, turn);
      }
      for (int i = 0; i < S::dimension; ++i) torque(c, at++) = -rate[i];
      const Vector3 spin = angular_to_3d(turn);
      for (int i = 0; i < S::angular_dimension; ++i) torque(c, at++) = -spin[S::angular_dimension == 1 ? 2 : i];
    }
  }
  return torque;
}

template <class S>
void KnownTermColumns<S>::load_columns(TreeState<S>& state, MatrixX& constant, MatrixX& changing) const {
  constant.setZero(tree_.columns, this->size());
  changing.setZero(tree_.columns, has_changes() ? this->size() : 0);
  const MatrixX torque = load_torques(state);
  const MatrixX together = has_changes() ? MatrixX(torque * changes_) : MatrixX();
  for (std::size_t t = 0; t < terms_.size(); ++t) {
    const Parameter& term = terms_[t];
    if (term.owner_kind != ParameterOwner::load) continue;
    const Eigen::Index component = load_component(term, S::dimension == 2), column = static_cast<Eigen::Index>(t);
    if (!is_load_change(term))
      constant.col(column) = torque.col(component);
    else if (has_changes())
      changing.col(column) = together.col(component);
  }
}

template <class S>
MatrixX KnownTermColumns<S>::friction_columns(const VectorX& dy) const {
  MatrixX torque = MatrixX::Zero(tree_.columns, size());
  for (std::size_t t = 0; t < terms_.size(); ++t) {
    const Parameter& term = terms_[t];
    if (term.owner_kind != ParameterOwner::friction) continue;
    const Friction& friction = mechanism_.friction[static_cast<std::size_t>(term.index)];
    const LinearQuantity& source = tree_.coordinate_expressions[static_cast<std::size_t>(friction.coordinate)];
    source.add_generalised_force(friction_resistance(term, source.rate(dy.data())),
                                 torque.col(static_cast<Eigen::Index>(t)).data());
  }
  return torque;
}

template class KnownTermColumns<Planar>;
template class KnownTermColumns<Spatial>;

}  // namespace balance
