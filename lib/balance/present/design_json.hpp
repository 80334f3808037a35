#pragma once
/// A design as JSON for programs.

#include "balance/present/design_view.hpp"

#include <string>
#include <vector>

namespace balance {

/// One object with everything of the view and the files written.
std::string design_json(const DesignReportData& view, const std::vector<std::string>& files);

}  // namespace balance
