#pragma once
/// Load cases and laws of adapted numbers as text and as JSON.

#include "balance/interface/files/json.hpp"
#include "balance/interface/files/text_options.hpp"
#include "balance/interface/reports/design_sections.hpp"

namespace balance::reports {

// Load cases and laws of adapted numbers as JSON.

/// Adds `load_cases` (empty if there are none) and `adaptive` (null if no number follows the load).
void add_load_cases(Json& json, const DesignReport& report);

/// Table of the cases, the law with its range, the work of adjustment, and the cases without adaptation; empty without
/// load cases. Parameters are as written. Unless verbose, successive rows with equal figures are one.
/// @param hidden_trajectories that have no column
std::string load_cases_text(const DesignReport& report, const files::TextOptions& options = {},
                            const std::vector<std::string>& hidden_trajectories = {});

/// Per free number, for format_balanced_spec(): an expression in the load's parameters if it follows them by a law
/// within its bounds; otherwise empty.
std::vector<std::string> make_law_expressions(const DesignReport& report);

}  // namespace balance::reports
