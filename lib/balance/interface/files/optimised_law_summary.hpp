#pragma once
/// A law of motion, or a way within a corridor, that was searched for, as text and JSON.

#include "balance/interface/files/json.hpp"
#include "balance/mechanics/trajectory/optimised_law.hpp"

#include <string>

namespace balance {

/// What was found, and a table of which limit is active when; ends with a line feed.
std::string format_optimised_law(const OptimisedLaw& law);

/// {duration, switches, stretches: [{begin, end, from, to, limit}]} and, of a gentlest law, {of, peak, unit}.
Json optimised_law_json(const OptimisedLaw& law);

/// How far the path is left, what was reached by it, and how many starts of the search agree; ends with a line feed.
std::string format_corridor_result(const CorridorResult& corridor);

/// {width, used, unit, of, value, on_path, value_unit, starts, agreeing}.
Json corridor_result_json(const CorridorResult& corridor);

}  // namespace balance
