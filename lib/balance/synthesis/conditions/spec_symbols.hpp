#pragma once
/// The lengths and ratios of a mechanism under the names that its spec gives them.

#include "balance/motion/study/design_space.hpp"
#include "balance/synthesis/conditions/coefficient_names.hpp"

namespace balance {

/// What the coefficients of conditions may be made of: the spec's parameters that govern geometric numbers as factors (`l1` of
/// `[l1, 0]`, of `[l1 / 2, 0]`), and the remaining numbers under names of their own (`link1.B.x`). Read off the spec's
/// expressions; without them (no recording) every number has its own name.
std::vector<GeometricSymbol> list_symbols(const DesignSpace& space);

}  // namespace balance
