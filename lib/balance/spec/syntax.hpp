#pragma once
/// Where an error of YAML's syntax is likely to come from. A parser tells where it could not go on, which may be lines below.

#include "balance/spec/problem.hpp"

#include <string>

namespace balance::specification {

/// What is wrong with a text that a parser gave up.
/// @param noticed where it gave up
/// @param why in its words
ReadError diagnose_syntax_error(const std::string& text, NodeLocation noticed, const std::string& why);

/// Whether a text in quotes that begins at a byte, behind its anchor and tag, ends; also true of what stands in no quotes.
bool is_quote_closed(const std::string& text, std::size_t begin);

}  // namespace balance::specification
