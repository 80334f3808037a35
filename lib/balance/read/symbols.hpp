#pragma once
/// The lengths and ratios of a mechanism under the names that its spec gives them.

#include "balance/conditions/naming.hpp"
#include "balance/spec/read_spec.hpp"

namespace balance {

/// What the coefficients of conditions may be made of: the spec's parameters that govern geometric numbers as factors (`l1` of
/// `[l1, 0]`, of `[l1 / 2, 0]`), and the remaining numbers under names of their own (`link1.B.x`). Found by reading the
/// spec again with every parameter a little larger and smaller.
/// @param options those that the study was read with
std::vector<Symbol> list_symbols(const Study& study, const ReadOptions& options = {});

}  // namespace balance
