#pragma once
/// What `subject_to` asks for, as functions that a search can call.

#include "balance/design/problem.hpp"
#include "balance/study/design_space.hpp"

namespace balance {

/// @param start, loose as for build_objective
/// @throws std::invalid_argument as build_objective
std::vector<DesignLimit> build_design_limits(const DesignSpace& space, const std::vector<FigureLimit>& limits,
                                             const VectorX& start, const FreeSprings& loose);

/// Those among them that are convex functions of the parameters along any motion. @param known how many they are
std::function<std::optional<std::vector<ConvexLimit>>(const VectorX& x)> build_convex_limits(
    const DesignSpace& space, const std::vector<FigureLimit>& limits, const FreeSprings& loose, int& known);

}  // namespace balance
