#pragma once
/// Load cases and laws of adapted numbers for people.

#include "balance/interface/files/json.hpp"
#include "balance/interface/reports/design_sections.hpp"

namespace balance {

// Load cases and laws of adapted numbers as JSON.

/// Adds `load_cases` (empty without any) and `adaptive` (null where no number follows the load).
void add_load_cases(Json& json, const DesignReport& report);

/// A table of the cases, the law with its range, what moving costs and what a fixed balance costs; empty without load cases. Numbers
/// are SI, parameters as written.
std::string load_cases_text(const DesignReport& report);

/// "-0.075 - 0.1 cargo.mass": a law of one adapted number.
/// @param digits significant ones @param times what stands between factors
std::string law_text(const AdaptiveLaw& law, Eigen::Index which, const std::vector<std::string>& loads, double unit = 1,
                     int digits = 6, const char* times = " ");

/// Per free number an expression over the load's parameters where it follows them by a law within its bounds, for format_balanced_spec;
/// else empty.
std::vector<std::string> make_law_expressions(const DesignReport& report);

}  // namespace balance
