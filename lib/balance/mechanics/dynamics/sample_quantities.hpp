#pragma once
/// What a moment of a tree in motion tells once its forces are balanced. State: poses, angular velocities, and accelerations with the
/// ground accelerated by −g.

#include "balance/mechanics/dynamics/tree_dynamics.hpp"
#include "balance/mechanics/kinematics/closure.hpp"
#include "balance/mechanics/trajectory/motion_sample.hpp"

namespace balance {

/// World axes; external wrenches and moments of inertia forces about the world's origin, the readings' about a point.
template <class S>
struct ForceBalance {
  const Wrench<S>& ground;           ///< what the ground exerts on everything, as inverse_dynamics() returns it
  const Wrench<S>&external, &loads;  ///< what loads and springs together do to the moving bodies, and the loads alone
  typename S::Vector gravity, about;
};

/// Centre of mass, shaking force and moment, what the frame feels.
template <class S>
void compute_total_forces(const Tree<Constants<S>>& tree, const TreeState<S>& state, const ForceBalance<S>& balance,
                          SampleOf<typename S::Scalar>& seen) {
  typename S::Vector moment = S::Vector::Zero();
  for (std::size_t n = 1; n < tree.nodes.size(); ++n) {
    const auto& inertia = tree.nodes[n].inertia;
    if (!tree.nodes[n].massless) moment += state[n].R_WN * inertia.first_moment + inertia.mass * state[n].p_WN;
  }
  seen.com = to_3d(typename S::Vector(moment / tree.mass));
  // the ground's wrench carries the weight and lacks what the surroundings supply
  const typename S::Vector weight = tree.mass * balance.gravity;
  const typename S::Angular weight_moment = cross(moment, balance.gravity);
  const typename S::Vector shaking = balance.ground.force + weight + balance.external.force;
  const typename S::Vector ground_force = weight + balance.loads.force - shaking;
  const typename S::Angular about_origin = balance.ground.moment + weight_moment + balance.external.moment;
  seen.shaking_force = to_3d(shaking);
  seen.shaking_moment = angular_to_3d(typename S::Angular(about_origin - cross(balance.about, shaking)));
  seen.com_acceleration = seen.shaking_force / tree.mass;
  seen.ground_force = to_3d(ground_force);
  seen.ground_moment = angular_to_3d(
      typename S::Angular(weight_moment + balance.loads.moment - about_origin - cross(balance.about, ground_force)));
}

/// After compute_total_forces(), with origins' velocities in the state. @param stored energy of springs [J]
template <class S>
void compute_energies(const Tree<Constants<S>>& tree, const TreeState<S>& state, const typename S::Vector& gravity,
                      const typename S::Scalar& stored, SampleOf<typename S::Scalar>& seen) {
  using T = typename S::Scalar;
  T kinetic = 0, potential = stored;
  for (std::size_t n = 1; n < tree.nodes.size(); ++n) {
    const auto& inertia = tree.nodes[n].inertia;
    const NodeState<S>& s = state[n];
    if (tree.nodes[n].massless) continue;
    kinetic += 0.5 * inertia.mass * s.velocity.squaredNorm() +
               dot(s.velocity, typename S::Vector(cross(s.angular_velocity, inertia.first_moment))) +
               0.5 * dot(s.angular_velocity, typename S::Angular(inertia.second_moment * s.angular_velocity));
  }
  potential -= tree.mass * to_3d(gravity).dot(seen.com);
  seen.kinetic_energy = kinetic;
  seen.potential_energy = potential;
}

/// What the cut joints transmit, and what the tree has to bear of it.
/// @param multipliers per closure row  @param wrenches what closures do is subtracted
template <class S>
void add_closure_wrenches(const Tree<Constants<S>>& tree, const TreeState<S>& state,
                          const std::vector<typename S::Scalar>& multipliers, std::vector<Wrench<S>>& wrenches,
                          SampleOf<typename S::Scalar>& seen) {
  int r = 0, constraint = 0;
  for (const Closure<Constants<S>>& closure : tree.closures) {
    const auto push = [&](int n, double sign, const Wrench<S>& wrench, const typename S::Vector& about) {
      if (n == 0) return;
      const NodeState<S>& s = state[n];
      const typename S::Vector force = sign * rotate_inverse(s.R_WN, wrench.force);
      wrenches[n].force -= force;
      wrenches[n].moment -= sign * rotate_inverse(s.R_WN, wrench.moment) +
                            cross(rotate_inverse(s.R_WN, typename S::Vector(about - s.p_WN)), force);
    };
    if (!closure.terms.empty()) {  // what it does to coordinates is not a body's to bear
      const typename S::Scalar multiplier = multipliers[r++];
      seen.constraint_force[constraint++] = multiplier;
      for (const VelocityTerm<Constants<S>>& term : closure.terms) {
        if (term.of == VelocityTerm<Constants<S>>::Of::column) continue;
        const ConstraintWrench<S> unit = speed_term_wrench(state, term);
        push(term.frame.node, 1, {multiplier * unit.force, multiplier * unit.moment}, position(state, term.frame));
      }
      continue;
    }
    const ClosurePose<S> pose = closure_pose(state, closure);
    Wrench<S> on_b;  // world axes, about b's origin
    for (const ClosureRow& row : closure.rows) {
      const typename S::Scalar multiplier = multipliers[r++];
      const ConstraintWrench<S> unit = closure_wrench(closure, pose, row);
      on_b.force += multiplier * unit.force;
      on_b.moment += multiplier * unit.moment;
    }
    if (!closure.split) {
      seen.joint_force[closure.joint] = to_3d(on_b.force);
      seen.joint_moment[closure.joint] = angular_to_3d(on_b.moment);
    }
    push(closure.b.node, 1, on_b, pose.p_B);
    push(closure.a.node, -1, on_b, pose.p_B);
  }
}

/// What the tree's joints transmit: on the second body, about the joint's point there. Of one that rolls, besides what the closures told.
/// @param wrenches what every node's parent exerts
template <class S>
void compute_joint_reactions(const MechanismOf<typename Constants<S>::Scalar>& mechanism,
                             const Tree<Constants<S>>& tree, const TreeState<S>& state,
                             const std::vector<Wrench<S>>& wrenches, SampleOf<typename S::Scalar>& seen) {
  for (std::size_t j = 0; j < mechanism.joints.size(); ++j) {
    const int n = tree.joint_nodes[j];
    if (n < 0) continue;
    const FixedFrame<Constants<S>>& second = tree.bodies[mechanism.joints[j].second];
    const typename S::Vector Q =
        state[second.node].p_WN +
        state[second.node].R_WN *
            typename Constants<S>::Vector(second.p_N +
                                          second.R_N * to_vector<Constants<S>>(mechanism.joints[j].point_second));
    const typename S::Vector force = state[n].R_WN * wrenches[n].force;
    const typename S::Angular moment =
        state[n].R_WN * wrenches[n].moment + cross(typename S::Vector(state[n].p_WN - Q), force);
    const double sign = tree.joint_forward[j] ? 1 : -1;
    if (!is_rolling(mechanism.joints[j].type)) seen.joint_force[j].setZero(), seen.joint_moment[j].setZero();
    seen.joint_force[j] += to_3d(typename S::Vector(sign * force));
    seen.joint_moment[j] += angular_to_3d(typename S::Angular(sign * moment));
  }
}

}  // namespace balance
