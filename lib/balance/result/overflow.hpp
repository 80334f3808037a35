#pragma once
/// Runs whose numbers grew too large to be computed with: their figures would be infinite or undefined.

#include "balance/model/mechanism.hpp"
#include "balance/result/metrics.hpp"

#include <optional>

namespace balance {

/// The first place where a quantity, or a figure made of it, is not finite. @param result with its metrics
std::optional<MotionOutcome> find_overflow(const RunResult& result, const IntermediateSamples& between,
                                           const Mechanism& mechanism);

}  // namespace balance
