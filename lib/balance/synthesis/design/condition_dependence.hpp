#pragma once
/// Which free numbers can change which conditions.

#include "balance/motion/study/design_space.hpp"
#include "balance/synthesis/conditions/conditions.hpp"

#include <functional>
#include <vector>

namespace balance {

/// Per condition the indices of the free numbers that its left-hand side depends on, found by changing each of them at a
/// point well inside the bounds.
/// @param conditions of the study at its start
/// @param derive as they were derived; asked again where lengths or ratios are free
/// @param loose as the conditions were derived with
std::vector<std::vector<int>> probe_condition_variables(const DesignSpace& space, const Conditions& conditions,
                                                        const std::function<Conditions(const Mechanism&)>& derive,
                                                        const FreeSprings& loose = {});

}  // namespace balance
