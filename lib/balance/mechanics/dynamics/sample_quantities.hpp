#pragma once
/// Quantities of a tree in motion that follow once its forces are balanced. State: poses, angular velocities, and
/// accelerations with the ground accelerated by −g.

#include "balance/mechanics/dynamics/tree_dynamics.hpp"
#include "balance/mechanics/kinematics/closure.hpp"
#include "balance/mechanics/trajectory/motion_sample.hpp"

namespace balance::dynamics {

/// World axes. External wrenches and moments of inertia forces are about the world's origin, reported moments about a
/// given point.
template <class S>
struct ForceBalance {
  const Wrench<S>& ground;           ///< exerted by the ground on everything, as inverse_dynamics() returns it
  const Wrench<S>&external, &loads;  ///< of loads and springs on the moving bodies; of the loads alone
  typename S::Vector gravity, about;
};

/// Centre of mass, shaking force and moment, wrench on the ground.
template <class S>
void compute_total_forces(const kinematics::Tree<kinematics::Constants<S>>& tree, const kinematics::TreeState<S>& state,
                          const ForceBalance<S>& balance, trajectory::SampleOf<typename S::Scalar>& sample) {
  typename S::Vector moment = S::Vector::Zero();
  for (std::size_t n = 1; n < tree.nodes.size(); ++n) {
    const auto& inertia = tree.nodes[n].inertia;
    if (!tree.nodes[n].massless) moment += state[n].R_WN * inertia.first_moment + inertia.mass * state[n].p_WN;
  }
  sample.com = kinematics::to_3d(typename S::Vector(moment / tree.mass));
  // the ground's wrench includes the weight, but not the external wrenches
  const typename S::Vector weight = tree.mass * balance.gravity;
  const typename S::Angular weight_moment = kinematics::cross(moment, balance.gravity);
  const typename S::Vector shaking = balance.ground.force + weight + balance.external.force;
  const typename S::Vector ground_force = weight + balance.loads.force - shaking;
  const typename S::Angular moment_about_origin = balance.ground.moment + weight_moment + balance.external.moment;
  sample.shaking_force = kinematics::to_3d(shaking);
  sample.shaking_moment =
      kinematics::angular_to_3d(typename S::Angular(moment_about_origin - kinematics::cross(balance.about, shaking)));
  sample.com_acceleration = sample.shaking_force / tree.mass;
  sample.ground_force = kinematics::to_3d(ground_force);
  sample.ground_moment = kinematics::angular_to_3d(typename S::Angular(
      weight_moment + balance.loads.moment - moment_about_origin - kinematics::cross(balance.about, ground_force)));
}

/// @pre compute_total_forces() was called, and the state holds the origins' velocities
/// @param spring_energy energy of springs [J]
template <class S>
void compute_energies(const kinematics::Tree<kinematics::Constants<S>>& tree, const kinematics::TreeState<S>& state,
                      const typename S::Vector& gravity, const typename S::Scalar& spring_energy,
                      trajectory::SampleOf<typename S::Scalar>& sample) {
  using T = typename S::Scalar;
  T kinetic = 0, potential = spring_energy;
  for (std::size_t n = 1; n < tree.nodes.size(); ++n) {
    const auto& inertia = tree.nodes[n].inertia;
    const kinematics::NodeState<S>& s = state[n];
    if (tree.nodes[n].massless) continue;
    kinetic +=
        0.5 * inertia.mass * s.velocity.squaredNorm() +
        kinematics::dot(s.velocity, typename S::Vector(kinematics::cross(s.angular_velocity, inertia.first_moment))) +
        0.5 * kinematics::dot(s.angular_velocity, typename S::Angular(inertia.second_moment * s.angular_velocity));
  }
  potential -= tree.mass * kinematics::to_3d(gravity).dot(sample.com);
  sample.kinetic_energy = kinetic;
  sample.potential_energy = potential;
}

/// Reactions of the cut joints, and their wrenches on the tree's nodes.
/// @param multipliers per closure row  @param wrenches the closures' wrenches are subtracted
template <class S>
void add_closure_wrenches(const kinematics::Tree<kinematics::Constants<S>>& tree, const kinematics::TreeState<S>& state,
                          const std::vector<typename S::Scalar>& multipliers, std::vector<Wrench<S>>& wrenches,
                          trajectory::SampleOf<typename S::Scalar>& sample) {
  int r = 0, constraint = 0;
  for (const kinematics::Closure<kinematics::Constants<S>>& closure : tree.closures) {
    const auto subtract_wrench = [&](int n, double sign, const Wrench<S>& wrench, const typename S::Vector& about) {
      if (n == 0) return;
      const kinematics::NodeState<S>& s = state[n];
      const typename S::Vector force = sign * rotate_inverse(s.R_WN, wrench.force);
      wrenches[n].force -= force;
      wrenches[n].moment -= sign * rotate_inverse(s.R_WN, wrench.moment) +
                            kinematics::cross(rotate_inverse(s.R_WN, typename S::Vector(about - s.p_WN)), force);
    };
    if (!closure.terms.empty()) {  // its terms in coordinates exert no wrench on a body
      const typename S::Scalar multiplier = multipliers[r++];
      sample.constraint_force[constraint++] = multiplier;
      for (const kinematics::VelocityTerm<kinematics::Constants<S>>& term : closure.terms) {
        if (term.of == kinematics::VelocityTerm<kinematics::Constants<S>>::Of::column) continue;
        const kinematics::ConstraintWrench<S> unit = speed_term_wrench(state, term);
        subtract_wrench(term.frame.node, 1, {multiplier * unit.force, multiplier * unit.moment},
                        position(state, term.frame));
      }
      continue;
    }
    const kinematics::ClosurePose<S> pose = closure_pose(state, closure);
    Wrench<S> wrench_on_b;  // world axes, about b's origin
    for (const kinematics::ClosureRow& row : closure.rows) {
      const typename S::Scalar multiplier = multipliers[r++];
      const kinematics::ConstraintWrench<S> unit = closure_wrench(closure, pose, row);
      wrench_on_b.force += multiplier * unit.force;
      wrench_on_b.moment += multiplier * unit.moment;
    }
    if (!closure.split) {
      sample.joint_force[closure.joint] = kinematics::to_3d(wrench_on_b.force);
      sample.joint_moment[closure.joint] = kinematics::angular_to_3d(wrench_on_b.moment);
    }
    subtract_wrench(closure.b.node, 1, wrench_on_b, pose.p_B);
    subtract_wrench(closure.a.node, -1, wrench_on_b, pose.p_B);
  }
}

/// Reactions of the tree's joints on the second body, about the joint's point there. For rolling joints they are added
/// to the closures' reactions.
/// @param wrenches exerted on every node by its parent
template <class S>
void compute_joint_reactions(const MechanismOf<typename kinematics::Constants<S>::Scalar>& mechanism,
                             const kinematics::Tree<kinematics::Constants<S>>& tree,
                             const kinematics::TreeState<S>& state, const std::vector<Wrench<S>>& wrenches,
                             trajectory::SampleOf<typename S::Scalar>& sample) {
  for (std::size_t j = 0; j < mechanism.joints.size(); ++j) {
    const int n = tree.joint_nodes[j];
    if (n < 0) continue;
    const kinematics::FixedFrame<kinematics::Constants<S>>& second = tree.bodies[mechanism.joints[j].second];
    const typename S::Vector Q =
        state[second.node].p_WN +
        state[second.node].R_WN * typename kinematics::Constants<S>::Vector(
                                      second.p_N + second.R_N * kinematics::to_vector<kinematics::Constants<S>>(
                                                                    mechanism.joints[j].point_second));
    const typename S::Vector force = state[n].R_WN * wrenches[n].force;
    const typename S::Angular moment =
        state[n].R_WN * wrenches[n].moment + kinematics::cross(typename S::Vector(state[n].p_WN - Q), force);
    const double sign = tree.joint_forward[j] ? 1 : -1;
    if (!is_rolling(mechanism.joints[j].type)) sample.joint_force[j].setZero(), sample.joint_moment[j].setZero();
    sample.joint_force[j] += kinematics::to_3d(typename S::Vector(sign * force));
    sample.joint_moment[j] += kinematics::angular_to_3d(typename S::Angular(sign * moment));
  }
}

}  // namespace balance::dynamics
