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
Configured first_moment(const Mechanism& mechanism, const Trajectory& trajectory) {
  Tree<S> tree = compile<S>(mechanism, prescribed_coordinates(trajectory));
  const Plan<S> plan = make_plan(mechanism, tree, trajectory);
  if (plan.outcome.status != MotionStatus::done) return {plan.outcome, {}};
  Stepper<S> stepper(mechanism, tree, plan);
  if (!stepper.begin()) return {stepper.outcome(), {}};
  Configured found;
  found.outcome.status = MotionStatus::done;
  const std::vector<double> q = read_coordinates(mechanism, tree, Eigen::Map<const VectorX>(stepper.y(), tree.columns));
  for (std::size_t c = 0; c < q.size(); ++c) found.coordinates.push_back({static_cast<int>(c), q[c]});
  return found;
}

}  // namespace

Configured start_configuration(const Mechanism& mechanism, const Trajectory& trajectory) {
  // a table has its start in itself; where rates are bound, `from` may leave the configuration to `assembly`
  if (std::holds_alternative<TablePath>(trajectory.path) || binds_rates(mechanism)) {
    const TimedTrajectory timed = time_law(mechanism, trajectory);
    if (timed.outcome.status != MotionStatus::done) return {timed.outcome, {}};
    return in_space(mechanism.space, [&]<class S>(S) { return first_moment<S>(mechanism, timed.trajectory); });
  }
  return find_configuration(mechanism, trajectory.from);
}

Configured end_configuration(const Mechanism& mechanism, Trajectory trajectory) {
  trajectory.samples = 2;
  Result run = simulate(mechanism, trajectory);
  Configured found{std::move(run.outcome), {}};
  if (found.outcome.status != MotionStatus::done) return found;
  for (Eigen::Index c = 0; c < run.joint_position.cols(); ++c)
    found.coordinates.push_back({static_cast<int>(c), run.joint_position(run.joint_position.rows() - 1, c)});
  return found;
}

}  // namespace balance
