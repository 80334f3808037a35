#pragma once
/// Fits Chebyshev series on panels to functions that can be sampled.

#include "balance/foundation/numerics/chebyshev_series.hpp"

#include <functional>
#include <vector>

namespace balance {

/// Values of all functions at increasing parameters, one row each. @return false if they cannot be had
using FunctionSampler = std::function<bool(const std::vector<double>& parameters, Samples& rows)>;

/// What a series is good for: where it ends, its last terms are so much smaller than the largest value on the panel.
inline constexpr double series_tolerance = 1e-10;

enum class FitStatus { done, not_sampled, not_resolved };

/// Fits panels to functions that are smooth between stations, halving panels until their series end.
/// @param stations increasing, at least two: the ends and where functions may jump
/// @param floor per function: smaller values are noise
FitStatus fit_chebyshev_series(const std::vector<double>& stations, const VectorX& floor, const FunctionSampler& sample,
                               PiecewiseChebyshevSeries& series);

}  // namespace balance
