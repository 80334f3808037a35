#pragma once
/// Loop-closure equations: their residuals, their Jacobian with respect to the tree coordinates, and the
/// velocity-product part of their second derivative.
///
/// Every row corresponds to a constraint wrench (F, N): its rate is F · (velocity of b relative to a at Q)
/// + N · (angular velocity of b relative to a), with Q the origin of frame b. With multiplier λ, the joint exerts λF at
/// Q and λN on b, and the opposite on a.

#include "balance/mechanics/kinematics/forward_kinematics.hpp"
#include "balance/mechanics/kinematics/tree.hpp"

#include <cmath>

namespace balance::kinematics {

// The contact point of a disc or a sphere with the plane on which it rolls.

/// Vector from the centre of a rolling body to its contact point, in space, and its rate at the angular velocity w
/// relative to the plane. World axes; the rate is that seen by an observer on the plane.
template <class T>
struct ContactVector {
  Vector3Of<T> arm, rate;

  ContactVector(const RollingContact<ModelScalarOf<T>>& contact, const Vector3Of<T>& normal,
                const Vector3Of<T>& spin_axis, const Vector3Of<T>& w) {
    if (!contact.disc) {
      arm = -contact.radius * normal;
      rate.setZero();
      return;
    }
    using std::sqrt;
    const Vector3Of<T> axis_rate = w.cross(spin_axis);
    const T lean = normal.dot(spin_axis);
    const Vector3Of<T> up = normal - lean * spin_axis;  // in the disc, away from the contact point
    const Vector3Of<T> up_rate = -normal.dot(axis_rate) * spin_axis - lean * axis_rate;
    const T up_norm = sqrt(up.squaredNorm());
    arm = -contact.radius / up_norm * up;
    rate = -contact.radius / up_norm * (up_rate - up.dot(up_rate) / (up_norm * up_norm) * up);
  }
};

/// A wrench on a body as a row: its power per unit rate of the coordinates of the nodes that carry the body.
template <class S>
struct ConstraintWrench {
  typename S::Vector force = S::Vector::Zero();  ///< world axes, through Q
  typename S::Angular moment = S::zero_angular();
};

/// Power of a wrench that acts at the point Q of a body carried by the node, per unit rate of the node's coordinate.
template <class S>
inline typename S::Scalar wrench_power(const Node<Constants<S>>& node, const NodeState<S>& state,
                                       const typename S::Vector& Q, const ConstraintWrench<S>& wrench) {
  if (node.motion == NodeMotion::prismatic) return node.ratio * dot(wrench.force, prismatic_axis(state.R_WN));
  return node.ratio * dot(revolute_axis(state.R_WN),
                          typename S::Angular(wrench.moment + cross(typename S::Vector(Q - state.p_WN), wrench.force)));
}

// Sums of speeds as rows: their values per unit rate of the coordinates, and the velocity-product part of their
// derivatives.

/// The wrench whose power equals a term of a sum of speeds. It acts through the term's own point.
template <class S>
inline ConstraintWrench<S> speed_term_wrench(const TreeState<S>& state, const VelocityTerm<Constants<S>>& term) {
  ConstraintWrench<S> wrench;
  const typename S::Rotation R = orientation(state, term.frame);
  if (term.of == VelocityTerm<Constants<S>>::Of::velocity) {
    if (term.is_in_body_axes)
      wrench.force = term.factor * axis(R, term.axis);
    else
      wrench.force[term.axis] = term.factor;
  } else if constexpr (S::angular_dimension == 1) {
    wrench.moment = term.factor;
  } else {
    if (term.is_in_body_axes)
      wrench.moment = term.factor * axis(R, term.axis);
    else
      wrench.moment[term.axis] = term.factor;
  }
  return wrench;
}

/// Value of a term of a sum of speeds per unit rate of the coordinate of a node that moves it.
template <class S>
inline typename S::Scalar speed_term_coefficient(const Tree<Constants<S>>& tree, const TreeState<S>& state,
                                                 const Closure<Constants<S>>& closure, const PathStep& step) {
  const VelocityTerm<Constants<S>>& term = closure.terms[step.term];
  if (term.of == VelocityTerm<Constants<S>>::Of::column) return term.factor;
  return wrench_power(tree.nodes[step.node], state[step.node], position(state, term.frame),
                      speed_term_wrench(state, term));
}

/// Rate of a sum of speeds when no coordinate accelerates. An acceleration of the ground does not count.
template <class S>
typename S::Scalar speed_sum_bias(const TreeState<S>& state, const Closure<Constants<S>>& closure) {
  typename S::Scalar sum = 0;
  for (const VelocityTerm<Constants<S>>& term : closure.terms) {
    if (term.of == VelocityTerm<Constants<S>>::Of::column) continue;
    const NodeState<S>& node = state[term.frame.node];
    const ConstraintWrench<S> unit = speed_term_wrench(state, term);
    if (term.of == VelocityTerm<Constants<S>>::Of::angular_velocity) {
      sum += dot(unit.moment, typename S::Angular(node.R_WN * node.angular_acceleration));
      continue;
    }
    sum += dot(unit.force, typename S::Vector(point_acceleration<S>(node, term.frame.p_N) - state[0].acceleration));
    if (term.is_in_body_axes)
      sum += dot(typename S::Vector(cross(typename S::Angular(node.R_WN * node.angular_velocity), unit.force)),
                 point_velocity<S>(node, term.frame.p_N));
  }
  return sum;
}

/// World poses of a closure's two frames; for a point closure the axes are the world's.
template <class S>
struct ClosurePose {
  typename S::Rotation R_A, R_B;
  typename S::Vector p_A, p_B;
};

/// Whether the closure only makes two points coincide, as for a planar revolute or a spherical joint. No axes are
/// needed, so its rows are the world components.
template <class S>
inline bool is_point_closure(const Closure<S>& closure) {
  return closure.has_coincident_origins && closure.rows.size() == S::dimension;
}

template <class S>
inline ClosurePose<S> closure_pose(const TreeState<S>& state, const Closure<Constants<S>>& closure) {
  if (is_point_closure(closure)) return {{}, {}, position(state, closure.a), position(state, closure.b)};
  if (!closure.terms.empty()) return {};
  return {orientation(state, closure.a), orientation(state, closure.b), position(state, closure.a),
          position(state, closure.b)};
}

/// Position residual of a row; zero for velocity-level rows.
template <class S>
inline typename S::Scalar closure_residual(const ClosurePose<S>& pose, const ClosureRow& row) {
  if (row.kind == ClosureRow::Kind::along) return dot(axis(pose.R_A, row.i), typename S::Vector(pose.p_B - pose.p_A));
  if (row.kind == ClosureRow::Kind::dot) return dot(axis(pose.R_A, row.i), axis(pose.R_B, row.j));
  return 0;
}

/// Factor that makes a row dimensionless and of order one: lengths are divided by the characteristic length.
template <class S>
inline double compute_row_scale(const Tree<S>& tree, const Closure<S>& closure, const ClosureRow& row) {
  if (row.kind == ClosureRow::Kind::sum) return 1 / closure.row_scale;
  return row.kind == ClosureRow::Kind::dot ? 1 : 1 / tree.characteristic_length;
}

template <class S>
inline ConstraintWrench<S> closure_wrench(const Closure<Constants<S>>& closure, const ClosurePose<S>& pose,
                                          const ClosureRow& row) {
  ConstraintWrench<S> wrench;
  if (row.kind == ClosureRow::Kind::dot) {
    wrench.moment = cross(axis(pose.R_B, row.j), axis(pose.R_A, row.i));
    return wrench;
  }
  wrench.force = axis(pose.R_A, row.i);
  if constexpr (S::dimension == 3)
    if (row.kind == ClosureRow::Kind::slip)  // it acts at the contact point
      wrench.moment = cross(
          ContactVector<typename S::Scalar>(closure.contact, axis(pose.R_A, 2), axis(pose.R_B, 1), S::Vector::Zero())
              .arm,
          wrench.force);
  return wrench;
}

/// Acceleration of b's origin as seen by an observer on a (world axes).
template <class S>
inline typename S::Vector relative_acceleration(const NodeState<S>& A, const NodeState<S>& B,
                                                const Closure<Constants<S>>& closure, const ClosurePose<S>& pose) {
  const typename S::Vector difference =
      point_acceleration<S>(B, closure.b.p_N) - point_acceleration<S>(A, closure.a.p_N);
  if (closure.has_coincident_origins) return difference;
  const typename S::Vector d = pose.p_B - pose.p_A;
  const typename S::Angular w = A.R_WN * A.angular_velocity;
  const typename S::Angular alpha = A.R_WN * A.angular_acceleration;
  const typename S::Vector slip =
      point_velocity<S>(B, closure.b.p_N) - point_velocity<S>(A, closure.a.p_N) - cross(w, d);
  return difference - times(make_acceleration_operator(w, alpha), d) - 2 * cross(w, slip);
}

/// Velocity of a point carried by a node, per unit rate of the node's coordinate.
template <class S>
inline typename S::Vector partial_velocity(const Node<Constants<S>>& node, const NodeState<S>& state,
                                           const typename S::Vector& point) {
  if (node.motion == NodeMotion::prismatic) return node.ratio * prismatic_axis(state.R_WN);
  return node.ratio * typename S::Vector(cross(revolute_axis(state.R_WN), typename S::Vector(point - state.p_WN)));
}

/// Value of a row of a velocity-level closure per unit rate of the coordinate of a node on its path.
template <class S>
inline typename S::Scalar velocity_row_coefficient(const Tree<Constants<S>>& tree, const TreeState<S>& state,
                                                   const Closure<Constants<S>>& closure, const ClosurePose<S>& pose,
                                                   const ClosureRow& row, const PathStep& step) {
  if (row.kind == ClosureRow::Kind::sum) return speed_term_coefficient(tree, state, closure, step);
  return step.sign *
         wrench_power(tree.nodes[step.node], state[step.node], pose.p_B, closure_wrench(closure, pose, row));
}

/// Second derivative of every row when no coordinate accelerates. State: accelerations with ddy = null, and velocities
/// (those of the origins only if the closure's origins do not coincide).
template <class S>
void closure_bias(const TreeState<S>& state, const Closure<Constants<S>>& closure, const ClosurePose<S>& pose,
                  typename S::Scalar* bias) {
  const NodeState<S>&A = state[closure.a.node], &B = state[closure.b.node];
  if (!closure.terms.empty()) {
    if (!closure.rows.empty()) bias[0] = speed_sum_bias(state, closure);
    return;
  }
  const typename S::Vector relative = relative_acceleration(A, B, closure, pose);
  if (is_point_closure(closure)) {
    for (int i = 0; i < S::dimension; ++i) bias[i] = relative[i];
    return;
  }
  const std::size_t rows = closure.rows.size();
  std::size_t r = 0;
  for (; r < rows && closure.rows[r].kind == ClosureRow::Kind::along; ++r)
    bias[r] = dot(axis(pose.R_A, closure.rows[r].i), relative);
  if (r == rows) return;
  const typename S::Angular w_A = A.R_WN * A.angular_velocity;
  const typename S::Angular w = typename S::Angular(B.R_WN * B.angular_velocity) - w_A;
  const typename S::Angular alpha = typename S::Angular(B.R_WN * B.angular_acceleration) -
                                    typename S::Angular(A.R_WN * A.angular_acceleration) -
                                    typename S::Angular(cross(w_A, w));
  const auto relative_operator = make_acceleration_operator(w, alpha);
  if constexpr (S::dimension == 3)
    if (closure.is_velocity_level()) {
      const ContactVector<typename S::Scalar> contact(closure.contact, axis(pose.R_A, 2), axis(pose.R_B, 1), w);
      const typename S::Vector slip = relative + cross(alpha, contact.arm) + cross(w, contact.rate);
      for (; r < rows; ++r) bias[r] = dot(axis(pose.R_A, closure.rows[r].i), slip);
      return;
    }
  for (; r < rows; ++r)
    bias[r] = dot(axis(pose.R_A, closure.rows[r].i),
                  typename S::Vector(times(relative_operator, axis(pose.R_B, closure.rows[r].j))));
}

/// Whether the joint's frames point in the same direction, not in opposite ones.
template <class S>
bool is_aligned(const ClosurePose<S>& pose, const Closure<Constants<S>>& closure) {
  for (const int k : closure.aligned)
    if (dot(axis(pose.R_A, k), axis(pose.R_B, k)) <= 0) return false;
  return true;
}

}  // namespace balance::kinematics
