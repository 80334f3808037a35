#pragma once
/// Sums of speeds as rows: their rates per unit rate of the coordinates, and what rates alone make of their derivatives. Private to
/// kinematics, motion and dynamics.

#include "balance/kinematics/row_wrench.hpp"

namespace balance {

/// The wrench whose power is a part of a sum of speeds, through the part's own point.
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

/// Rate of a sum of speeds' part per unit rate of the coordinate of a node that moves it.
template <class S>
inline typename S::Scalar speed_term_coefficient(const Tree<Constants<S>>& tree, const TreeState<S>& state,
                                                 const Closure<Constants<S>>& closure, const PathStep& step) {
  const VelocityTerm<Constants<S>>& term = closure.terms[step.term];
  if (term.of == VelocityTerm<Constants<S>>::Of::column) return term.factor;
  return wrench_power(tree.nodes[step.node], state[step.node], position(state, term.frame),
                      speed_term_wrench(state, term));
}

/// How a sum of speeds changes when no coordinate accelerates; the ground may, which does not count.
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

}  // namespace balance
