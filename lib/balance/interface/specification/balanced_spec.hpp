#pragma once
/// The spec of a designed mechanism.

#include "balance/motion/study/study.hpp"

#include <string>

namespace balance {

/// The text that a study was read from with numbers in place of its free ones and with what `--set` overrode; comments, order and
/// layout stay as they are. Reading it without `--set` gives the mechanism at x.
/// @param x values of study.free_numbers (SI, parameters as written)
/// @param expressions per free number a text that takes the place of its number, if not empty
/// @return every number is the shortest text that reads back to the same value, in the spec's own unit
/// @param left_out elements that the text is written without
/// @throws std::invalid_argument if x or expressions have another length or is not finite
std::string format_balanced_spec(const Study& study, const VectorX& x, const std::vector<std::string>& expressions = {},
                                 const std::vector<OptionalElementText>& left_out = {});

}  // namespace balance
