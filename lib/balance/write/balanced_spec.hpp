#pragma once
/// The spec of a designed mechanism.

#include "balance/study/study.hpp"

#include <string>

namespace balance {

/// The text that a study was read from with numbers in place of its free ones and with what `--set` overrode; comments, order and
/// layout stay as they are. Reading it without `--set` gives the mechanism at x.
/// @param x values of study.free_numbers (SI, parameters as written)
/// @return every number is the shortest text that reads back to the same value, in the spec's own unit
/// @throws std::invalid_argument if x has another length or is not finite
std::string balanced_spec(const Study& study, const VectorX& x);

}  // namespace balance
