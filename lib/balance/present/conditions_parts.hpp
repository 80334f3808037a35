#pragma once
/// Pieces of JSON that tell of goals and conditions. Private to the writers: it knows the JSON library.

#include "balance/present/conditions_view.hpp"
#include "balance/write/json_parts.hpp"

namespace balance {

/// One name, or a list if there are several.
Json goals_json(const std::vector<Goal>& goals);

/// Text, LaTeX, terms, residual, … of every condition.
Json conditions_list_json(const ConditionsReportData& view);

/// Rank, gap and singular values, the parameters' names, the symbols, the conditions and the notes, added to an object.
void add_conditions(Json& json, const ConditionsReportData& view);

}  // namespace balance
