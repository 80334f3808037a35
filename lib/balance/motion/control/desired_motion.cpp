#include "balance/motion/control/desired_motion.hpp"

#include "balance/mechanics/dynamics/tree_motion_source.hpp"

#include <stdexcept>

namespace balance::control {

namespace {

template <class S>
MotionOutcome displace_tool_in(const Mechanism& mechanism, const Trajectory& trajectory, const Vector3& displacement,
                               double angle, VectorX& position) {
  const auto [tree, plan] = kinematics::CompiledMotion<S>(mechanism, trajectory);
  if (plan.outcome.status != MotionStatus::done) return plan.outcome;
  trajectory::PoseTarget pose;
  pose.tool = Vector3::Zero();
  if constexpr (std::is_same_v<S, kinematics::Planar>)
    if (plan.freedoms >= 3) pose.angle = 0;
  const kinematics::PoseEquations<S> equations = make_pose_equations(mechanism, tree, pose);
  kinematics::ConstraintSystem<S> system(tree, equations.drive);
  VectorX residual;
  MatrixX jacobian;
  system.evaluate(plan.start, equations.target, residual, jacobian);
  const trajectory::DriveSample from = system.measure(plan.start);
  trajectory::DriveSample to = from;
  for (int i = 0; i < S::dimension; ++i) to.value[i] += displacement[i];
  if (pose.angle) to.value[S::dimension] += angle;
  const kinematics::AssemblySolution solution = track_to(system, plan.start, from, to);
  if (!solution.found) return {MotionStatus::unreachable, 0, "the initial error puts the tool out of reach", {}};
  for (std::size_t c = 0; c < mechanism.coordinates.size(); ++c) {
    const kinematics::LinearQuantity& expression = tree.coordinate_expressions[c];
    if (expression.has_terms()) position[static_cast<Eigen::Index>(c)] = expression.value(solution.y.data());
  }
  return {MotionStatus::done, 0, "", {}};
}

}  // namespace

trajectory::MotionTable compute_desired_motion(const Mechanism& mechanism, const Trajectory& trajectory,
                                               const std::vector<double>& times) {
  if (times.empty() || times.front() != 0) throw std::invalid_argument("a desired motion begins at time 0");
  return kinematics::dispatch_space(mechanism.space, [&]<class S>(S) {
    const kinematics::CompiledMotion<S> motion(mechanism, trajectory);
    dynamics::TreeMotionSource<S> source(mechanism, motion, trajectory.about, dynamics::Detail::kinematics);
    return sample_motion(mechanism, source, times);
  });
}

MotionOutcome displace_tool(const Mechanism& mechanism, const Trajectory& trajectory, const Vector3& displacement,
                            double angle, VectorX& position) {
  return kinematics::dispatch_space(mechanism.space, [&]<class S>(S) {
    return displace_tool_in<S>(mechanism, trajectory, displacement, angle, position);
  });
}

}  // namespace balance::control
