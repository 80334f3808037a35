#pragma once
/// Follows the assembly mode of a mechanism as its lengths change.

#include "balance/motion/study/design_space.hpp"

namespace balance::design {

/// The space with the assembly mode of its start values, which is followed continuously from there to the start
/// configuration of the first trajectory for other numbers. Unchanged if no free number changes a length, if there is
/// nothing to assemble, or if the start values cannot be assembled.
DesignSpace follow_assembly_mode(DesignSpace space);

}  // namespace balance::design
