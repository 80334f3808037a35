#pragma once
/// How the least duration changes with what limits it. Private to timing.

#include "balance/timing/fastest.hpp"
#include "balance/timing/row_value.hpp"

#include <functional>

namespace balance {

/// Derivatives of a row's magnitude less its bound with respect to any parameters, at a moment of the motion.
using ConstraintGradient = std::function<VectorX(const PathPoint& moment, const ConstraintValue& here)>;

/// Derivatives of the duration of a fastest law from rest to rest in one leg. Every arc keeps its row at the bound; what the
/// parameters change there is carried along it from the place that decides its speed: the start, the end, or where a ceiling is
/// touched. Derivation: docs/motion.md.
/// @param parameters how many entries the slopes have
VectorX differentiate_duration(const PathModel& model, const std::vector<double>& bounds, const TimeOptimalLaw& law,
                               const ConstraintGradient& slopes, Eigen::Index parameters);

}  // namespace balance
