#include "balance/present/front_view.hpp"

#include "balance/present/design_view.hpp"
#include "balance/present/names.hpp"
#include "balance/write/csv_field.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace balance {

namespace {

std::string with_unit(const std::string& name, const std::string& unit) {
  return csv_field(unit.empty() ? name : fmt::format("{} [{}]", name, unit));
}

}  // namespace

FrontView make_front_view(const DesignStudyOptions& options, const DesignSpace& space, Front front) {
  FrontView view;
  view.title = space.start.mechanism.name;
  view.goals = options.goals.empty() ? space.start.design.goals : options.goals;
  for (const std::vector<ObjectiveTerm>& terms : space.start.design.front.figures) {
    view.figures.push_back(objective_text(terms));
    view.units.push_back(objective_unit(terms, space.start.mechanism));
  }
  view.numbers = space.start.free_numbers;
  view.seconds = options.search.seconds;
  view.warnings = space.start.warnings;
  view.front = std::move(front);
  return view;
}

Optimality optimality_of(const Front& front) {
  const auto has = [&](Optimality optimality) {
    return std::any_of(front.points.begin(), front.points.end(),
                       [&](const FrontPoint& point) { return point.optimality == optimality; });
  };
  if (front.points.empty()) return front.failure.outcome.optimality;
  if (front.stopped || has(Optimality::stopped)) return Optimality::stopped;
  return has(Optimality::local_best) ? Optimality::local_best : Optimality::proved_best;
}

std::string front_csv(const FrontView& view) {
  std::string text = "point";
  for (std::size_t j = 0; j < view.figures.size(); ++j) text += "," + with_unit(view.figures[j], view.units[j]);
  text += ",optimality,minimized,lower_bound";
  for (const FreeNumber& number : view.numbers) text += "," + csv_field(number.path);
  text += "\n";
  for (std::size_t k = 0; k < view.front.points.size(); ++k) {
    const FrontPoint& point = view.front.points[k];
    text += fmt::format("{}", k + 1);
    for (const double value : point.values) text += fmt::format(",{:.17g}", value);
    text += fmt::format(",{},{},{:.17g}", name_of(point.optimality),
                        csv_field(view.figures[static_cast<std::size_t>(point.minimized)]), point.lower_bound);
    for (const double value : point.report.outcome.x) text += fmt::format(",{:.17g}", value);
    text += "\n";
  }
  return text;
}

}  // namespace balance
