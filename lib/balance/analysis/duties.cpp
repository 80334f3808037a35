#include "balance/analysis/duties.hpp"

#include "balance/analysis/start_pose.hpp"
#include "balance/cost/trajectory_cost.hpp"
#include "balance/simulation/simulate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

namespace balance {

namespace {

/// As often looked at as a search needs.
Trajectory reduce_samples(Trajectory trajectory) {
  constexpr long max_feasibility_samples = 201;
  trajectory.samples = std::min(trajectory.samples, max_feasibility_samples);
  return trajectory;
}

std::string motion_failure_reason(const Mechanism& mechanism, const Trajectory& trajectory) {
  try {
    const RunResult result = simulate(mechanism, trajectory);
    return result.outcome.status == MotionStatus::done ? "" : result.outcome.reason;
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
}

}  // namespace

RequiredMotions::RequiredMotions(const Study& start) : coordinates_(balance::start_coordinates(start)) {
  std::vector<Trajectory> all;
  for (const Trajectory& trajectory : start.trajectories) {
    if (is_mass_dependent(trajectory)) continue;
    all.push_back(reduce_samples(trajectory));
    if (motion_failure_reason(start.mechanism, all.back()).empty()) motions_.push_back(all.back().name);
  }
  if (coordinates_.empty())
    for (const Trajectory& trajectory : all) motions_.push_back(trajectory.name);
}

std::string RequiredMotions::infeasibility_reason(const DesignInstance& trial) const {
  for (const Trajectory& trajectory : trial.trajectories) {
    if (std::find(motions_.begin(), motions_.end(), trajectory.name) == motions_.end()) continue;
    const std::string why = motion_failure_reason(trial.mechanism, reduce_samples(trajectory));
    if (!why.empty()) return fmt::format("'{}' cannot be followed: {}", trajectory.name, why);
  }
  return "";
}

}  // namespace balance
