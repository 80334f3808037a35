#include "balance/present/front_view.hpp"

#include "balance/present/design_view.hpp"
#include "balance/present/names.hpp"
#include "balance/write/csv_field.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace balance {

namespace {

std::string with_unit(const std::string& name, const std::string& unit) {
  return escape_csv_field(unit.empty() ? name : fmt::format("{} [{}]", name, unit));
}

/// A number that follows the load, in one of the cases.
struct AdaptedNumber {
  std::size_t load_case;
  Eigen::Index number;
};

/// "counterweights.cw.at[0] (case 2)", one load after the other.
std::vector<std::pair<std::string, AdaptedNumber>> adapted_numbers(const FrontReportData& view) {
  std::vector<std::pair<std::string, AdaptedNumber>> all;
  const std::vector<ParetoPoint>& points = view.front.points;
  if (points.empty() || !points.front().report.adaptive) return all;
  const DesignReport& report = points.front().report;
  for (std::size_t k = 0; k < report.load_cases.size(); ++k)
    for (const int number : report.adaptive->numbers)
      all.emplace_back(fmt::format("{} (case {})", view.numbers[static_cast<std::size_t>(number)].key_path, k + 1),
                       AdaptedNumber{k, number});
  return all;
}

}  // namespace

FrontReportData make_front_report_data(const DesignStudyOptions& options, const DesignSpace& space, ParetoFront front) {
  FrontReportData view;
  view.title = space.start.mechanism.name;
  view.goals = options.goals.empty() ? space.start.design.goals : options.goals;
  for (const std::vector<ObjectiveTerm>& terms : space.start.design.front.figures) {
    view.figures.push_back(objective_text(terms));
    view.units.push_back(objective_unit(terms, space.start.mechanism));
  }
  view.numbers = space.start.free_numbers;
  view.seconds = options.search.max_time;
  view.warnings = space.start.warnings;
  view.front = std::move(front);
  return view;
}

Optimality front_optimality(const ParetoFront& front) {
  const auto has = [&](Optimality optimality) {
    return std::any_of(front.points.begin(), front.points.end(),
                       [&](const ParetoPoint& point) { return point.optimality == optimality; });
  };
  if (front.points.empty()) return front.failure.outcome.optimality;
  if (front.is_budget_exhausted || has(Optimality::budget_exhausted)) return Optimality::budget_exhausted;
  return has(Optimality::local_optimum) ? Optimality::local_optimum : Optimality::proved_global;
}

std::string front_csv(const FrontReportData& view) {
  std::string text = "point";
  for (std::size_t j = 0; j < view.figures.size(); ++j) text += "," + with_unit(view.figures[j], view.units[j]);
  text += ",optimality,minimized,lower_bound";
  for (const FreeNumber& number : view.numbers) text += "," + escape_csv_field(number.key_path);
  for (const auto& [path, which] : adapted_numbers(view)) text += "," + escape_csv_field(path);
  text += "\n";
  for (std::size_t k = 0; k < view.front.points.size(); ++k) {
    const ParetoPoint& point = view.front.points[k];
    text += fmt::format("{}", k + 1);
    for (const double value : point.values) text += fmt::format(",{:.17g}", value);
    text += fmt::format(",{},{},{:.17g}", name_of(point.optimality),
                        escape_csv_field(view.figures[static_cast<std::size_t>(point.minimized)]), point.lower_bound);
    for (const double value : point.report.outcome.x) text += fmt::format(",{:.17g}", value);
    for (const auto& [path, which] : adapted_numbers(view))
      text += fmt::format(",{:.17g}", point.report.load_cases[which.load_case].x[which.number]);
    text += "\n";
  }
  return text;
}

}  // namespace balance
