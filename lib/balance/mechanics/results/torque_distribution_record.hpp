#pragma once
/// How a run's efforts were distributed over more actuators than degrees of freedom, and which bounds they exceed.

#include "balance/mechanics/model/mechanism.hpp"

#include <cstddef>
#include <vector>

namespace balance::results {

struct RunResult;

/// An actuator whose effort is outside its bounds at some time.
struct BoundExcess {
  int actuator = 0;
  double excess = 0;                     ///< largest, > 0 [N m or N]
  double time = 0;                       ///< of the largest excess [s]
  double effort = 0, bound = 0;          ///< at that time [N m or N]
  double first_time = 0, last_time = 0;  ///< first and last sample with an excess [s]
};

struct TorqueDistributionRecord {
  TorqueDistribution distribution;
  std::vector<BoundExcess> excesses;  ///< in the order of the actuators
};

/// What determines the efforts of a run.
enum class EffortOrigin {
  motion,     ///< the prescribed motion, so that excesses over bounds are the least possible
  controller  ///< also errors of tracking
};

/// If the mechanism has a torque distribution, sets result.torque_distribution, and adds a note for every actuator that
/// exceeds a bound. @param intermediate, count further rows of the same run, and how many of them are filled
void record_torque_distribution(const Mechanism& mechanism, const RunResult& intermediate, std::size_t count,
                                EffortOrigin origin, RunResult& result);

}  // namespace balance::results
