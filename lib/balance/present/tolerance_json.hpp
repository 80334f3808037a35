#pragma once
/// How far runs are off when a mechanism's numbers are, as JSON.

#include "balance/present/tolerance_view.hpp"

#include <string>

namespace balance {

/// Deviations are null where a figure has none to first order, and so are parts of numbers that open a joint; `sampling` and `at_rest` where nobody asked.
std::string tolerance_json(const ToleranceReportData& view);

}  // namespace balance
