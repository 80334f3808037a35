#pragma once
/// The configurations that a trajectory begins and ends at.

#include "balance/inverse/configuration.hpp"
#include "balance/motion/trajectory.hpp"

namespace balance {

/// Found without a run where the trajectory's `from` tells it.
ConfigurationResult find_start_configuration(const Mechanism& mechanism, const Trajectory& trajectory);

/// In the assembly mode that a run comes in.
ConfigurationResult find_end_configuration(const Mechanism& mechanism, Trajectory trajectory);

}  // namespace balance
