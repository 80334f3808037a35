#include "balance/simulation/end_poses.hpp"

#include "balance/kinematics/joint_coordinates.hpp"
#include "balance/kinematics/space.hpp"
#include "balance/motion/drive_quantities.hpp"
#include "balance/motion/plan.hpp"
#include "balance/motion/stepper.hpp"
#include "balance/simulation/simulate.hpp"
#include "balance/timing/time_law.hpp"

#include <utility>
#include <variant>
#include <vector>

namespace balance {

namespace {

/// Where a run begins, whatever becomes of it on the way.
template <class S>
ConfigurationResult find_first_configuration(const Mechanism& mechanism, const Trajectory& trajectory) {
  Tree<S> tree = compile_tree<S>(mechanism, prescribed_coordinates(trajectory));
  const CompiledTrajectory<S> plan = compile_trajectory(mechanism, tree, trajectory);
  if (plan.outcome.status != MotionStatus::done) return {plan.outcome, {}};
  MotionStepper<S> stepper(mechanism, tree, plan);
  if (!stepper.begin()) return {stepper.outcome(), {}};
  ConfigurationResult found;
  found.outcome.status = MotionStatus::done;
  const std::vector<double> q =
      compute_coordinates(mechanism, tree, Eigen::Map<const VectorX>(stepper.y(), tree.columns));
  for (std::size_t c = 0; c < q.size(); ++c) found.coordinates.push_back({static_cast<int>(c), q[c]});
  return found;
}

}  // namespace

ConfigurationResult find_start_configuration(const Mechanism& mechanism, const Trajectory& trajectory) {
  // a table has its start in itself; where rates are bound, `from` may leave the configuration to `assembly`
  if (std::holds_alternative<TablePath>(trajectory.path) || has_velocity_constraints(mechanism)) {
    const ResolvedTrajectory timed = resolve_trajectory(mechanism, trajectory);
    if (timed.outcome.status != MotionStatus::done) return {timed.outcome, {}};
    return dispatch_space(mechanism.space,
                          [&]<class S>(S) { return find_first_configuration<S>(mechanism, timed.trajectory); });
  }
  return solve_configuration(mechanism, trajectory.from);
}

ConfigurationResult find_end_configuration(const Mechanism& mechanism, Trajectory trajectory) {
  trajectory.samples = 2;
  RunResult run = simulate(mechanism, trajectory);
  ConfigurationResult found{std::move(run.outcome), {}};
  if (found.outcome.status != MotionStatus::done) return found;
  for (Eigen::Index c = 0; c < run.joint_position.cols(); ++c)
    found.coordinates.push_back({static_cast<int>(c), run.joint_position(run.joint_position.rows() - 1, c)});
  return found;
}

}  // namespace balance
