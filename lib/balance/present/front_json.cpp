// A trade-off as JSON.

#include "balance/present/conditions_parts.hpp"
#include "balance/present/front_view.hpp"
#include "balance/present/load_cases_json.hpp"
#include "balance/present/names.hpp"

#include <algorithm>

namespace balance {
namespace {

Json figures_json(const FrontReportData& view) {
  Json list = Json::array();
  for (std::size_t j = 0; j < view.figures.size(); ++j) {
    Json figure = {{"name", view.figures[j]}, {"unit", view.units[j]}};
    if (j < view.front.anchors.size()) {
      const ParetoAnchor& end = view.front.anchors[j];
      figure["least"] = end.min_value;
      figure["lower_bound"] = end.lower_bound;
      figure["optimality"] = name_of(end.optimality);
    }
    list.push_back(std::move(figure));
  }
  return list;
}

Json numbers_list(const FrontReportData& view, const VectorX& x) {
  Json list = Json::array();
  for (std::size_t i = 0; i < view.numbers.size(); ++i)
    list.push_back({{"path", view.numbers[i].key_path}, {"value", x[static_cast<Eigen::Index>(i)]}});
  return list;
}

Json point_json(const FrontReportData& view, std::size_t k) {
  const ParetoPoint& point = view.front.points[k];
  Json json = {{"point", k + 1},
               {"values", numbers_json(point.values)},
               {"free_numbers", numbers_list(view, point.report.outcome.x)},
               {"status", name_of(point.report.outcome.status)},
               {"optimality", name_of(point.optimality)},
               {"minimized", point.minimized},
               {"limits", numbers_json(point.limits)},
               {"lower_bound", point.lower_bound},
               {"gap", point.gap()},
               {"tried", point.report.outcome.search_summary}};
  if (!point.report.load_cases.empty()) add_load_cases(json, point.report);
  return json;
}

}  // namespace

std::string front_json(const FrontReportData& view, const std::vector<std::string>& files, const std::string& design) {
  const ParetoFront& front = view.front;
  const bool none = front.points.empty();
  const DesignReport& shown = none ? front.failure : front.points.front().report;
  Json json = {{"mechanism", view.title}, {"goal", goals_json(view.goals)}};
  json["status"] = name_of(shown.outcome.status);
  json["optimality"] = name_of(front_optimality(front));
  json["reason"] = none ? shown.outcome.reason : "";
  json["seconds"] = view.seconds;
  Json points = Json::array();
  for (std::size_t k = 0; k < front.points.size(); ++k) points.push_back(point_json(view, k));
  json["front"] = {{"figures", figures_json(view)},
                   {"points", std::move(points)},
                   {"middle", none ? Json(nullptr) : Json(find_compromise_point(front) + 1)},
                   {"searches", front.searches},
                   {"stopped", front.is_budget_exhausted}};
  if (!design.empty()) json["design"] = Json::parse(design);
  json["notes"] = front.notes;
  json["warnings"] = view.warnings;
  json["files"] = files;
  return format_json(json);
}

}  // namespace balance
