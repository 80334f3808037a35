#pragma once
/// A law of motion, or a way within a corridor, that was searched for, as text and JSON. Private to the writers and the page.

#include "balance/motion/found_law.hpp"
#include "balance/write/json_parts.hpp"

#include <string>

namespace balance {

/// What was found, and a table of which limit is active when; ends with a line feed.
std::string found_law_text(const FoundLaw& law);

/// {duration, switches, stretches: [{begin, end, from, to, limit}]} and, of a gentlest law, {of, peak, unit}.
Json found_law_json(const FoundLaw& law);

/// How far the path is left, what was reached by it, and how many starts of the search agree; ends with a line feed.
std::string found_corridor_text(const FoundCorridor& corridor);

/// {width, used, unit, of, value, on_path, value_unit, starts, agreeing}.
Json found_corridor_json(const FoundCorridor& corridor);

}  // namespace balance
