#pragma once
/// How well a law keeps its limits between its nodes. Private to timing.

#include "balance/timing/fastest.hpp"

#include <vector>

namespace balance {

/// Limits are kept to this part of them.
constexpr double limit_violation_tolerance = 1e-6;

/// Between two nodes, joined by a quintic. @return the worst load, as a part of its bound
double find_max_limit_ratio_between(const PathModel& model, const std::vector<double>& bounds,
                                    AccelerationLimits& allowed, const TimeLawNode& a, const TimeLawNode& b);

/// Between all nodes of a law.
double find_max_limit_ratio(const PathModel& model, const std::vector<double>& bounds, const TimeOptimalLaw& law);

}  // namespace balance
