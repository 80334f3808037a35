#pragma once
/// An optimised law of motion, or an optimised path within a corridor, as text and JSON.

#include "balance/interface/files/report_fields.hpp"
#include "balance/mechanics/trajectory/optimised_law.hpp"

#include <string>

namespace balance::files {

/// When a quantity is at its limit.
ReportFields<trajectory::ActiveLimitInterval> active_limit_fields();

/// The law found, and a table of which limit is active when; ends with a newline.
std::string format_optimised_law(const trajectory::OptimisedLaw& law, const TextOptions& options = {});

/// {duration, switches, stretches: [{begin, end, from, to, limit}]} and, for a gentlest law, {of, peak, unit}.
Json optimised_law_json(const trajectory::OptimisedLaw& law);

/// Maximum offset from the path, the objective reached, and the number of starts that agree; ends with a newline.
std::string format_corridor_result(const trajectory::CorridorResult& corridor,
                                   const specification::SpecUnits& units = {});

/// {width, used, unit, of, value, on_path, value_unit, starts, agreeing}.
Json corridor_result_json(const trajectory::CorridorResult& corridor);

}  // namespace balance::files
