#pragma once
/// Load cases and laws of adapted numbers as JSON.

#include "balance/present/design_view.hpp"
#include "balance/write/json_parts.hpp"

namespace balance {

/// Adds `load_cases` (empty without any) and `adaptive` (null where no number follows the load).
void add_load_cases(Json& json, const DesignReport& report);

}  // namespace balance
