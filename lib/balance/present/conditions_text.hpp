#pragma once
/// Balancing conditions as text for people.

#include "balance/present/conditions_view.hpp"

#include <string>

namespace balance {

/// Goal, rank and gap, then the conditions by number with what they miss now and which free numbers they depend on. What no disc can
/// miss is named in one line. Ends with a line feed.
std::string conditions_text(const ConditionsReportData& view);

/// One condition on lines of at most `width` characters, broken between terms; an over-long term has a line of its own.
std::vector<std::string> wrap_condition(const ConditionsReportData& view, int row, std::size_t width);

/// "l1 = 0.5 m, push.fy = -5 N": what the symbols and known terms stand for; "" if there are none.
std::string symbols_text(const ConditionsReportData& view);

/// What cannot be balanced, an element a line with the efforts that it leaves; "" if there is nothing.
std::string format_remainder(const ConditionsReportData& view);

/// "1–4, 7" of rows that are counted from one.
std::string format_ranges(const std::vector<int>& rows);

}  // namespace balance
