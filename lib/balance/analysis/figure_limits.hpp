#pragma once
/// What `subject_to` asks for, as functions that a search can call.

#include "balance/design/problem.hpp"
#include "balance/study/design_space.hpp"

namespace balance {

/// @param start, loose as for build_objective
/// @throws std::invalid_argument as build_objective
std::vector<DesignLimit> build_limits(const DesignSpace& space, const std::vector<FigureLimit>& limits,
                                      const VectorX& start, const LooseSprings& loose);

}  // namespace balance
