#pragma once
/// The spec of a designed mechanism.

#include "balance/motion/study/study.hpp"

#include <string>

namespace balance::specification {

/// The text that a study was read from, with numbers in place of its free ones and with the overrides of `--set`;
/// comments, order and layout are preserved. Reading it without `--set` gives the mechanism at x.
/// @param x values of study.free_numbers (SI, parameters as written)
/// @param expressions per free number a text that replaces its number, unless empty
/// @param omitted_elements elements to remove from the text
/// @return every number is the shortest text that reads back to the same value, in the spec's own unit
/// @throws std::invalid_argument if x or expressions have the wrong length or x is not finite
std::string format_balanced_spec(const Study& study, const VectorX& x, const std::vector<std::string>& expressions = {},
                                 const std::vector<study::OptionalElementText>& omitted_elements = {});

}  // namespace balance::specification
