#pragma once
/// What `subject_to` asks for, as functions that a search can call.

#include "balance/design/problem.hpp"
#include "balance/study/design_space.hpp"

namespace balance {

/// @param start, loose as for build_objective
/// @throws std::invalid_argument as build_objective
std::vector<DesignLimit> build_limits(const DesignSpace& space, const std::vector<FigureLimit>& limits,
                                      const VectorX& start, const LooseSprings& loose);

/// Those among them that are convex functions of the parameters along any motion. @param known how many they are
std::function<std::optional<std::vector<BoundedFigures>>(const VectorX& x)> build_bounded(
    const DesignSpace& space, const std::vector<FigureLimit>& limits, const LooseSprings& loose, int& known);

}  // namespace balance
