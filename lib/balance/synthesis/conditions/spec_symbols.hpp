#pragma once
/// The lengths and ratios of a mechanism under the names in its spec.

#include "balance/motion/study/design_space.hpp"
#include "balance/synthesis/conditions/coefficient_names.hpp"

namespace balance::conditions {

/// Symbols for the coefficients of conditions: the spec's parameters that are factors of geometric numbers (`l1` in
/// `[l1, 0]` or `[l1 / 2, 0]`), and the remaining numbers under their own names (`link1.B.x`). They are found in the
/// spec's expressions; without these (no recording) every number has its own name.
std::vector<GeometricSymbol> list_symbols(const DesignSpace& space);

}  // namespace balance::conditions
