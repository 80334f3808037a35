#pragma once
/// Balancing conditions as JSON for programs.

#include "balance/present/conditions_view.hpp"

#include <string>
#include <vector>

namespace balance {

/// One object with everything of the view, conditions that hold by definition included.
std::string conditions_json(const ConditionsReportData& view, const std::vector<std::string>& warnings);

}  // namespace balance
