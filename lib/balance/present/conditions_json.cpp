#include "balance/present/conditions_json.hpp"

#include "balance/present/conditions_parts.hpp"
#include "balance/present/names.hpp"

namespace balance {

std::string conditions_json(const ConditionsReportData& view, const std::vector<std::string>& warnings) {
  Json json = {{"mechanism", view.title}, {"goal", goals_json(view.conditions.goals)}};
  json["meaning"] = Json::array();
  for (const Goal& goal : view.conditions.goals) json["meaning"].push_back(describe_goal(goal));
  json["strategy"] = view.strategy;
  json["status"] = name_of(view.conditions.status);
  add_conditions(json, view);
  json["warnings"] = warnings;
  return format_json(json);
}

}  // namespace balance
