#include "balance/simulation/end_poses.hpp"

#include "balance/simulation/simulate.hpp"

#include <utility>
#include <variant>

namespace balance {

namespace {

/// @param last whether the last row is meant, else the first
Configured row_of_run(const Mechanism& mechanism, const Trajectory& trajectory, bool last) {
  Result run = simulate(mechanism, trajectory);
  Configured found{std::move(run.outcome), {}};
  if (found.outcome.status != MotionStatus::done) return found;
  const Eigen::Index row = last ? run.joint_position.rows() - 1 : 0;
  for (Eigen::Index c = 0; c < run.joint_position.cols(); ++c)
    found.coordinates.push_back({static_cast<int>(c), run.joint_position(row, c)});
  return found;
}

}  // namespace

Configured start_configuration(const Mechanism& mechanism, const Trajectory& trajectory) {
  // a table has its start in itself; where rates are bound, `from` may leave the configuration to `assembly`
  if (std::holds_alternative<TablePath>(trajectory.path) || binds_rates(mechanism))
    return row_of_run(mechanism, trajectory, false);
  return find_configuration(mechanism, trajectory.from);
}

Configured end_configuration(const Mechanism& mechanism, Trajectory trajectory) {
  trajectory.samples = 2;
  return row_of_run(mechanism, trajectory, true);
}

}  // namespace balance
