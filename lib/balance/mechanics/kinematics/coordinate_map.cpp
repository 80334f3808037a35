#include "balance/foundation/base/elementary.hpp"
#include "balance/foundation/base/rotation.hpp"
#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/mechanics/kinematics/joint_coordinates.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace balance::kinematics {

namespace {

/// Angular velocity of a spherical joint's child relative to its parent, per unit rate of each of its nodes, in the
/// parent's axes.
template <class S>
Matrix3 spherical_axes(const Tree<S>& tree, const double* y, NodeId spherical) {
  Matrix3 axes = Matrix3::Zero(), R = Matrix3::Identity();
  for (int n = spherical; n < spherical + 3; ++n) {
    const Node<S>& node = tree.nodes[n];
    const bool is_revolute = node.motion == NodeMotion::revolute;
    const double x = is_revolute ? node.ratio * y[node.column] + node.offset : 0;
    R *= to_matrix(rotate_about_joint_axis(node.R_PF, elementary::cos(x), elementary::sin(x)));
    if (is_revolute) axes.col(n - spherical) = node.ratio * R.col(2);
  }
  return axes;
}

/// The two remaining rotations of a locked spherical joint, from the joint's three: the line keeps its orientation.
void set_locked_spherical(const Mechanism& mechanism, const Tree<Spatial>& tree, const model::PassiveFreedom& freedom,
                          const VectorX& q, const VectorX& dq, VectorX& y, VectorX& dy) {
  for (const int j : freedom.joints) {
    if (tree.joint_nodes[j] < 0 || tree.joint_nodes[j] != tree.bodies[freedom.body].node) continue;
    const Joint& joint = mechanism.joints[j];
    std::size_t c = 0;
    while (mechanism.coordinates[c].joint != j) ++c;
    const auto k = static_cast<Eigen::Index>(c);
    const Vector3 x = Vector3::UnitX();
    const Matrix3 Ra = rotation_about(x, q[k]), Rab = Ra * rotation_about(Vector3::UnitY(), q[k + 1]);
    const Matrix3 R = Rab * rotation_about(Vector3::UnitZ(), q[k + 2]) * joint.rotation;
    const Vector3 w = dq[k] * x + dq[k + 1] * Ra.col(1) + dq[k + 2] * Rab.col(2);
    const bool forward = tree.joint_forward[j];
    const Matrix3 R_child = forward ? R : Matrix3(R.transpose());
    const Vector3 w_child = forward ? w : Vector3(-(R.transpose() * w));
    const Matrix3 axes =
        frame_with_z_along((forward ? joint.rotation : Matrix3(joint.rotation.transpose())) * freedom.line);
    const Vector3 line = R_child * freedom.line;
    const Vector3 s = axes.transpose() * line, ds = axes.transpose() * w_child.cross(line);
    const int first = tree.coordinate_expressions[c].terms[0].first,
              second = tree.coordinate_expressions[c + 1].terms[0].first;
    const double transverse_squared = std::max(1e-12, s.y() * s.y() + s.z() * s.z());
    y[first] = elementary::atan2(-s.y(), s.z());
    y[second] = elementary::asin(std::clamp(s.x(), -1.0, 1.0));
    dy[first] = (s.y() * ds.z() - ds.y() * s.z()) / transverse_squared;
    dy[second] = ds.x() / std::sqrt(transverse_squared);
  }
}

}  // namespace

template <class S>
void to_tree_coordinates(const Mechanism& mechanism, const Tree<S>& tree, const VectorX& q, const VectorX& dq,
                         VectorX& y, VectorX& dy) {
  y.setZero(tree.columns);
  dy.setZero(tree.columns);
  const auto set_columns = [&](bool is_leader) {
    for (std::size_t c = 0; c < mechanism.coordinates.size(); ++c) {
      const LinearQuantity& source = tree.coordinate_expressions[c];
      if (!source.has_single_term() || source.is_column() != is_leader) continue;
      const auto& [column, ratio] = source.terms[0];
      if (ratio == 0) continue;
      const auto k = static_cast<Eigen::Index>(c);
      y[column] = (q[k] - source.constant) / ratio;
      dy[column] = dq[k] / ratio;
    }
  };
  set_columns(false);
  set_columns(true);  // leaders take precedence where several coordinates share a column
  if constexpr (std::is_same_v<S, Spatial>)
    for (const model::PassiveFreedom& freedom : tree.locked_freedoms)
      set_locked_spherical(mechanism, tree, freedom, q, dq, y, dy);
  for (int c = 0; c < tree.columns; ++c) {
    if (!std::isfinite(y[c])) y[c] = 0;
    if (!std::isfinite(dy[c])) dy[c] = 0;
  }
}

template <class S>
void to_joint_coordinates(const Mechanism& mechanism, const Tree<S>& tree, const TreeState<S>& state, const double* y,
                          const double* dy, const double* ddy, VectorX& q, VectorX& dq, VectorX& ddq) {
  const auto count = static_cast<Eigen::Index>(mechanism.coordinates.size());
  q.resize(count), dq.resize(count), ddq.resize(count);
  int measured_joint = -1;
  JointMotion<double> joint_motion;
  for (Eigen::Index c = 0; c < count; ++c) {
    const Coordinate& coordinate = mechanism.coordinates[c];
    const LinearQuantity& source = tree.coordinate_expressions[c];
    if (source.has_terms() && !tree.is_floating[c]) {
      q[c] = source.value(y);
      dq[c] = source.rate(dy);
      ddq[c] = source.rate(ddy);
      continue;
    }
    if (measured_joint != coordinate.joint) {
      const Joint& joint = mechanism.joints[coordinate.joint];
      joint_motion = compute_joint_motion(joint, relative_motion(tree, state, joint));
      measured_joint = coordinate.joint;
    }
    q[c] = joint_motion.position[coordinate.index];
    dq[c] = joint_motion.velocity[coordinate.index];
    ddq[c] = joint_motion.acceleration[coordinate.index];
  }
}

template <class S>
void transfer_spherical_rates(const Tree<S>& before, const double* y, const Tree<S>& after, const double* y_after,
                              NodeId spherical, double* dy) {
  const Matrix3 old_axes = spherical_axes(before, y, spherical), new_axes = spherical_axes(after, y_after, spherical);
  Vector3 w = Vector3::Zero();
  for (int k = 0; k < 3; ++k)
    if (before.nodes[spherical + k].motion == NodeMotion::revolute)
      w += dy[before.nodes[spherical + k].column] * old_axes.col(k);
  Vector3 rates;
  if (after.nodes[spherical + 2].motion == NodeMotion::revolute) {
    rates = new_axes.inverse() * w;
  } else {  // the component along the locked line is dropped
    rates = Vector3(new_axes.col(0).dot(w) / new_axes.col(0).squaredNorm(),
                    new_axes.col(1).dot(w) / new_axes.col(1).squaredNorm(), 0);
  }
  for (int k = 0; k < 3; ++k)
    if (after.nodes[spherical + k].motion == NodeMotion::revolute) dy[after.nodes[spherical + k].column] = rates[k];
}

std::string format_configuration(const Mechanism& mechanism, const VectorX& q) {
  std::string text;
  char number[64];
  for (Eigen::Index c = 0; c < std::min<Eigen::Index>(q.size(), 12); ++c) {
    std::snprintf(number, sizeof number, " %.6g", q[c]);
    text += (text.empty() ? "" : ", ") + mechanism.coordinates[c].name + number;
  }
  return text;
}

#define BALANCE_INSTANTIATE(S)                                                                                     \
  template void to_tree_coordinates<S>(const Mechanism&, const Tree<S>&, const VectorX&, const VectorX&, VectorX&, \
                                       VectorX&);                                                                  \
  template void to_joint_coordinates<S>(const Mechanism&, const Tree<S>&, const TreeState<S>&, const double*,      \
                                        const double*, const double*, VectorX&, VectorX&, VectorX&);               \
  template void transfer_spherical_rates<S>(const Tree<S>&, const double*, const Tree<S>&, const double*, NodeId,  \
                                            double*);
BALANCE_INSTANTIATE(Planar)
BALANCE_INSTANTIATE(Spatial)
#undef BALANCE_INSTANTIATE

template <class S>
std::vector<double> compute_coordinates(const Mechanism& mechanism, const Tree<S>& tree, const VectorX& y) {
  TreeState<S> state(tree.nodes.size());
  compute_poses(tree, y.data(), state);
  std::vector<double> values;
  for (std::size_t c = 0; c < mechanism.coordinates.size(); ++c) {
    const Coordinate& coordinate = mechanism.coordinates[c];
    const LinearQuantity& source = tree.coordinate_expressions[c];
    const Joint& joint = mechanism.joints[coordinate.joint];
    const double value =
        source.has_terms() && !tree.is_floating[c]
            ? source.value(y.data())
            : compute_joint_motion(joint, relative_motion(tree, state, joint)).position[coordinate.index];
    values.push_back(coordinate.kind == CoordinateKind::angle ? unwrap_angle(value, 0) : value);
  }
  return values;
}

template std::vector<double> compute_coordinates<Planar>(const Mechanism&, const Tree<Planar>&, const VectorX&);
template std::vector<double> compute_coordinates<Spatial>(const Mechanism&, const Tree<Spatial>&, const VectorX&);

}  // namespace balance::kinematics
