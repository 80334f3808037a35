#pragma once
/// A law of motion that was searched for, as text and JSON. Private to the writers and the page.

#include "balance/motion/found_law.hpp"
#include "balance/write/json_parts.hpp"

#include <string>

namespace balance {

/// What was found, and a table of which limit is active when; ends with a line feed.
std::string found_law_text(const FoundLaw& law);

/// {duration, switches, stretches: [{begin, end, from, to, limit}]} and, of a gentlest law, {of, peak, unit}.
Json found_law_json(const FoundLaw& law);

}  // namespace balance
