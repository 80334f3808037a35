#pragma once
/// How far runs are off when a mechanism's numbers are, for people.

#include "balance/present/tolerance_view.hpp"

#include <string>

namespace balance {

std::string tolerance_text(const ToleranceReportData& view);

}  // namespace balance
