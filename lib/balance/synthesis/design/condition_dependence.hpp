#pragma once
/// Dependence of conditions on free numbers.

#include "balance/motion/study/design_space.hpp"
#include "balance/synthesis/conditions/conditions.hpp"

#include <functional>
#include <vector>

namespace balance::design {

/// For each condition, the indices of the free numbers that its left-hand side depends on, found by changing each
/// number at a point well inside the bounds.
/// @param conditions of the study at its start
/// @param derive derives conditions in the same way; called again if lengths or ratios are free
/// @param loose as used for deriving the conditions
std::vector<std::vector<int>> probe_condition_variables(const DesignSpace& space, const Conditions& conditions,
                                                        const std::function<Conditions(const Mechanism&)>& derive,
                                                        const dynamics::FreeSprings& loose = {});

}  // namespace balance::design
