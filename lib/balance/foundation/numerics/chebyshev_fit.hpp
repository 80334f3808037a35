#pragma once
/// Fits piecewise Chebyshev series to functions that can be sampled.

#include "balance/foundation/numerics/chebyshev_series.hpp"

#include <functional>
#include <vector>

namespace balance::numerics {

/// Samples all functions at increasing parameters: one row per parameter, one column per function. @return false if that fails
using FunctionSampler = std::function<bool(const std::vector<double>& parameters, Samples& rows)>;

/// A series has converged if its last terms are below this fraction of the sum of its |coefficients|.
inline constexpr double series_tolerance = 1e-10;

enum class FitStatus { done, not_sampled, not_resolved };

/// Fits functions that are smooth between breakpoints, bisecting panels until their series converge.
/// @param breakpoints increasing, at least two: the ends and where functions may jump
/// @param floor per function: smaller values count as zero
FitStatus fit_chebyshev_series(const std::vector<double>& breakpoints, const VectorX& floor,
                               const FunctionSampler& sample, PiecewiseChebyshevSeries& series);

}  // namespace balance::numerics
