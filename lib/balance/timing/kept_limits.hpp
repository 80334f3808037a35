#pragma once
/// How well a law keeps its limits between its nodes. Private to timing.

#include "balance/timing/fastest.hpp"

#include <vector>

namespace balance {

/// Limits are kept to this part of them.
constexpr double kept = 1e-6;

/// Between two nodes, joined by a quintic. @return the worst load, as a part of its bound
double load_between(const PathModel& model, const std::vector<double>& bounds, Allowed& allowed, const TimedNode& a,
                    const TimedNode& b);

/// Between all nodes of a law.
double worst_load(const PathModel& model, const std::vector<double>& bounds, const FastestLaw& law);

}  // namespace balance
