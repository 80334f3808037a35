#pragma once
/// What is asked of a law that is searched for, and its search along one path. Private to timing.

#include "balance/timing/gentlest.hpp"
#include "balance/timing/stated_limits.hpp"

namespace balance {

/// Of the law fastest or gentlest: the limits, and behind their quantities those whose peak is to be least.
/// @throws std::invalid_argument if what the law needs is missing, or it cannot be found for this mechanism
PathLimits make_law_limits(const Mechanism& mechanism, const Trajectory& trajectory);

/// @param model of the task's quantities @return the law, or its refusal, with the peak reached if that is what is sought
MinPeakLaw find_motion_law(const PathModel& model, const PathLimits& task, const Trajectory& trajectory);

}  // namespace balance
