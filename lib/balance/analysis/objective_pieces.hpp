#pragma once
/// A weighted sum of figures as a sum of maxima of smooth functions of the free numbers, with slopes. Private to analysis.

#include "balance/design/problem.hpp"
#include "balance/dynamics/parameter.hpp"
#include "balance/study/design_space.hpp"

#include <optional>
#include <vector>

namespace balance {

/// Every figure as what it is a maximum of: a peak of the extremes of short stretches of the run, a range of two such maxima, others of
/// themselves alone.
/// @return nothing where a trajectory cannot be followed
/// @throws SpecError, std::invalid_argument where the numbers make no mechanism or motion
std::optional<std::vector<MaxTerm>> compute_max_terms(const DesignSpace& space, const std::vector<ObjectiveTerm>& terms,
                                                      const FreeSprings& loose, const VectorX& x);

}  // namespace balance
