#pragma once
/// The configuration that a pose means: every coordinate of a mechanism where its tool, some of its joints or its centre of mass are.

#include "balance/model/mechanism.hpp"
#include "balance/motion/motion.hpp"
#include "balance/motion/trajectory.hpp"

#include <vector>

namespace balance {

struct ConfigurationResult {
  MotionOutcome
      outcome;  ///< done; not_assembled, unreachable; drive_singularity, mismatch: the pose does not tell enough
  std::vector<CoordinateValue> coordinates;  ///< all of the mechanism, if done
};

/// In the assembly mode nearest to the mechanism's `assembly`.
/// @throws std::invalid_argument if the pose names a tool that the mechanism lacks
ConfigurationResult solve_configuration(const Mechanism& mechanism, const PoseTarget& pose);

}  // namespace balance
