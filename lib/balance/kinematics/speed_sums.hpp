#pragma once
/// Sums of speeds as rows: their rates per unit rate of the coordinates, and what rates alone make of their derivatives. Private to
/// kinematics, motion and dynamics.

#include "balance/kinematics/row_wrench.hpp"

namespace balance {

/// The wrench whose power is a part of a sum of speeds, through the part's own point.
template <class S>
inline RowWrench<S> term_wrench(const State<S>& state, const RateTerm<Constants<S>>& term) {
  RowWrench<S> wrench;
  const typename S::Rotation R = orientation(state, term.frame);
  if (term.of == RateTerm<Constants<S>>::Of::velocity) {
    if (term.own)
      wrench.force = term.factor * axis(R, term.axis);
    else
      wrench.force[term.axis] = term.factor;
  } else if constexpr (S::angular == 1) {
    wrench.moment = term.factor;
  } else {
    if (term.own)
      wrench.moment = term.factor * axis(R, term.axis);
    else
      wrench.moment[term.axis] = term.factor;
  }
  return wrench;
}

/// Rate of a sum of speeds' part per unit rate of the coordinate of a node that moves it.
template <class S>
inline typename S::Scalar term_rate(const Tree<Constants<S>>& tree, const State<S>& state,
                                    const Closure<Constants<S>>& closure, const PathStep& step) {
  const RateTerm<Constants<S>>& term = closure.terms[step.term];
  if (term.of == RateTerm<Constants<S>>::Of::column) return term.factor;
  return power_of(tree.nodes[step.node], state[step.node], position(state, term.frame), term_wrench(state, term));
}

/// How a sum of speeds changes when no coordinate accelerates; the ground may, which does not count.
template <class S>
typename S::Scalar sum_bias(const State<S>& state, const Closure<Constants<S>>& closure) {
  typename S::Scalar sum = 0;
  for (const RateTerm<Constants<S>>& term : closure.terms) {
    if (term.of == RateTerm<Constants<S>>::Of::column) continue;
    const NodeState<S>& node = state[term.frame.node];
    const RowWrench<S> unit = term_wrench(state, term);
    if (term.of == RateTerm<Constants<S>>::Of::turning) {
      sum += dot(unit.moment, typename S::Angular(node.R_WN * node.angular_acceleration));
      continue;
    }
    sum += dot(unit.force, typename S::Vector(point_acceleration<S>(node, term.frame.p_N) - state[0].acceleration));
    if (term.own)
      sum += dot(typename S::Vector(cross(typename S::Angular(node.R_WN * node.angular_velocity), unit.force)),
                 point_velocity<S>(node, term.frame.p_N));
  }
  return sum;
}

}  // namespace balance
