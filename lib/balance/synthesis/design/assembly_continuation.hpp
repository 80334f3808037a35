#pragma once
/// Follows the assembly mode of a mechanism as its lengths change.

#include "balance/motion/study/design_space.hpp"

#include <vector>

namespace balance::design {

/// Whether designs must be in the assembly mode of the start values.
/// @param terms to be minimised
bool keeps_assembly_mode(const study::DesignRequest& request, const std::vector<ObjectiveTerm>& terms);

/// The space with the assembly mode of its start values, which is followed continuously from there to the start
/// configuration of the first trajectory for other numbers. Unchanged if no free number changes a length, if there is
/// nothing to assemble, or if the start values cannot be assembled.
/// @param keeps_mode whether numbers for which that mode does not exist are no designs; otherwise they are in the mode
///   nearest to the start values or to the spec's `assembly`
DesignSpace follow_assembly_mode(DesignSpace space, bool keeps_mode);

}  // namespace balance::design
