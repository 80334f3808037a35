#pragma once
/// A design as text for people.

#include "balance/present/design_view.hpp"

#include <string>

namespace balance {

/// What was reached and why it is not more, the free numbers, the conditions, what the design costs and what every
/// trajectory gains. Ends with a line feed.
std::string design_text(const DesignReportData& view);

}  // namespace balance
