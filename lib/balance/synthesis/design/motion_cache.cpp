#include "balance/synthesis/design/motion_cache.hpp"

#include "balance/motion/simulation/simulate.hpp"
#include "balance/synthesis/design/required_motions.hpp"

#include <algorithm>
#include <stdexcept>

namespace balance::design {

namespace {

/// Numbers in the rows of all motions, eight bytes each, and number of motions, that are kept.
constexpr Eigen::Index max_cached_numbers = 8'000'000;
constexpr std::size_t max_cached_motions = 400;

}  // namespace

Eigen::Index MotionCache::Motion::size() const {
  Eigen::Index count = 0;
  for (const auto& [quantity, series] : rows)
    if (series)
      for (const AffineSeries& one : *series) count += one.rows.size();
  return count;
}

MotionCache::Motion& MotionCache::find(const Mechanism& mechanism, const Trajectory& trajectory,
                                       const dynamics::FreeSprings& loose) {
  VectorX numbers = collect_motion_numbers(mechanism, trajectory);
  const auto known = std::find_if(motions_.begin(), motions_.end(), [&](const Motion& motion) {
    return motion.samples == trajectory.samples && motion.trajectory == trajectory.name && motion.loose == loose &&
           motion.numbers == numbers;
  });
  if (known != motions_.end())
    motions_.splice(motions_.begin(), motions_, known);
  else
    motions_.push_front({std::move(numbers), trajectory.name, trajectory.samples, loose, {}, {}});
  return motions_.front();
}

std::shared_ptr<const MotionCache::Series> MotionCache::rows(const Mechanism& mechanism, const Trajectory& trajectory,
                                                             const dynamics::FreeSprings& loose,
                                                             const std::string& quantity) {
  requested_quantities_[{trajectory.name, trajectory.samples}].insert(quantity);
  Motion& motion = find(mechanism, trajectory, loose);
  if (!motion.rows.contains(quantity)) {
    const Eigen::Index size_before = motion.size();
    add_rows(mechanism, trajectory, quantity, motion);
    size_ += motion.size() - size_before;
    drop_old_motions();
  }
  return motion.rows.at(quantity);
}

void MotionCache::add_rows(const Mechanism& mechanism, const Trajectory& trajectory, const std::string& quantity,
                           Motion& motion) {
  std::vector<std::string> missing = {quantity};
  for (const std::string& other : requested_quantities_[{trajectory.name, trajectory.samples}])
    if (other != quantity && !motion.rows.contains(other)) missing.push_back(other);
  auto series = TrajectoryCost(mechanism, trajectory, motion.loose).rows(missing);
  for (std::size_t q = 0; q < missing.size(); ++q)
    motion.rows[missing[q]] = series[q] ? std::make_shared<const Series>(std::move(*series[q])) : nullptr;
}

CostFunction MotionCache::cost(const Mechanism& mechanism, const Trajectory& trajectory,
                               const dynamics::FreeSprings& loose, Statistic figure, const std::string& quantity) {
  Motion& motion = find(mechanism, trajectory, loose);
  const std::pair key(figure, quantity);
  if (const auto known = motion.costs.find(key); known != motion.costs.end()) return known->second;
  motion.costs[key] = TrajectoryCost(mechanism, trajectory, loose).figure(figure, quantity).value_or(CostFunction{});
  drop_old_motions();
  return motion.costs[key];
}

results::UniformTurning MotionCache::turning(const Mechanism& mechanism, const Trajectory& trajectory) {
  Motion& motion = find(mechanism, trajectory, {});
  if (!motion.turning) {
    const RunResult run = simulate(mechanism, trajectory);
    if (run.outcome.status != MotionStatus::done) throw std::invalid_argument(run.outcome.reason);
    motion.turning = results::find_uniform_turning(run);
  }
  return *motion.turning;
}

/// Keeps the last one used.
void MotionCache::drop_old_motions() {
  while (motions_.size() > 1 && (motions_.size() > max_cached_motions || size_ > max_cached_numbers)) {
    size_ -= motions_.back().size();
    motions_.pop_back();
  }
}

}  // namespace balance::design
