#pragma once
/// What depends only on motions, kept for designs, load cases and figures that share them: those that differ only in
/// masses do.

#include "balance/mechanics/results/orders.hpp"
#include "balance/synthesis/design/trajectory_cost.hpp"

#include <list>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace balance::design {

class MotionCache {
 public:
  using Series = std::vector<AffineSeries>;

  /// The rows of a linear quantity along the motion; nullptr if TrajectoryCost has none. All quantities that were ever
  /// asked for along a trajectory are computed together, in one pass along each motion.
  /// @param loose as for TrajectoryCost
  std::shared_ptr<const Series> rows(const Mechanism& mechanism, const Trajectory& trajectory,
                                     const dynamics::FreeSprings& loose, const std::string& quantity);

  /// How a coordinate turns uniformly along the motion, whatever the masses.
  /// @throws std::invalid_argument as results::find_uniform_turning()
  results::UniformTurning turning(const Mechanism& mechanism, const Trajectory& trajectory);

  /// A figure along the motion as a function of the parameters; empty if TrajectoryCost has none.
  CostFunction cost(const Mechanism& mechanism, const Trajectory& trajectory, const dynamics::FreeSprings& loose,
                    Statistic figure, const std::string& quantity);

 private:
  struct Motion {
    VectorX numbers;  ///< collect_motion_numbers
    std::string trajectory;
    long samples = 0;
    dynamics::FreeSprings loose;
    std::map<std::string, std::shared_ptr<const Series>> rows;        ///< by quantity
    std::map<std::pair<Statistic, std::string>, CostFunction> costs;  ///< by figure and quantity
    std::optional<results::UniformTurning> turning = {};
    Eigen::Index size() const;  ///< how many numbers the rows have
  };

  Motion& find(const Mechanism& mechanism, const Trajectory& trajectory, const dynamics::FreeSprings& loose);
  void add_rows(const Mechanism& mechanism, const Trajectory& trajectory, const std::string& quantity, Motion& motion);
  void drop_old_motions();

  std::list<Motion> motions_;  ///< the last one used is first
  Eigen::Index size_ = 0;      ///< of all motions
  /// By trajectory and number of samples.
  std::map<std::pair<std::string, long>, std::set<std::string>> requested_quantities_;
};

}  // namespace balance::design
