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
Trajectory shortened(Trajectory trajectory) {
  constexpr long enough = 201;
  trajectory.samples = std::min(trajectory.samples, enough);
  return trajectory;
}

std::string why_not(const Mechanism& mechanism, const Trajectory& trajectory) {
  try {
    const Result result = simulate(mechanism, trajectory);
    return result.outcome.status == MotionStatus::done ? "" : result.outcome.reason;
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
}

}  // namespace

Duties::Duties(const Study& start) : coordinates_(start_coordinates(start)) {
  std::vector<Trajectory> all;
  for (const Trajectory& trajectory : start.trajectories) {
    if (depends_on_masses(trajectory)) continue;
    all.push_back(shortened(trajectory));
    if (why_not(start.mechanism, all.back()).empty()) motions_.push_back(all.back().name);
  }
  if (coordinates_.empty())
    for (const Trajectory& trajectory : all) motions_.push_back(trajectory.name);
}

std::string Duties::obstacle(const Trial& trial) const {
  for (const Trajectory& trajectory : trial.trajectories) {
    if (std::find(motions_.begin(), motions_.end(), trajectory.name) == motions_.end()) continue;
    const std::string why = why_not(trial.mechanism, shortened(trajectory));
    if (!why.empty()) return fmt::format("'{}' cannot be followed: {}", trajectory.name, why);
  }
  return "";
}

}  // namespace balance
