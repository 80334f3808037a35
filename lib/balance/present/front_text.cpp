// A trade-off for people.

#include "balance/present/front_view.hpp"
#include "balance/present/names.hpp"
#include "balance/write/table.hpp"

#include <fmt/format.h>

#include <cmath>

namespace balance {
namespace {

/// Of a figure; what is less than this part of its largest value is shown as zero.
constexpr double zero_value_tolerance = 1e-12;

std::string value_text(double value, double largest) {
  return std::abs(value) <= zero_value_tolerance * largest ? "0" : format_number(value);
}

VectorX largest_of(const ParetoFront& front) {
  VectorX most = VectorX::Zero(front.points.front().values.size());
  for (const ParetoPoint& point : front.points) most = most.cwiseMax(point.values.cwiseAbs());
  return most;
}

/// The figures are called a, b, c.
std::string letter(std::size_t j) { return std::string(1, static_cast<char>('a' + j)); }

std::string legend(const FrontReportData& view) {
  std::string text;
  for (std::size_t j = 0; j < view.figures.size(); ++j) {
    text += fmt::format("{}  {}{}", letter(j), view.figures[j],
                        view.units[j].empty() ? "" : fmt::format(" [{}]", view.units[j]));
    const ParetoAnchor end = j < view.front.anchors.size() ? view.front.anchors[j] : ParetoAnchor{};
    if (end.optimality == Optimality::proved_global) text += fmt::format("; {:.6g} is proved the least", end.min_value);
    text += "\n";
  }
  return text;
}

/// "a ≥ 3.2": what no design within the point's limits is below.
std::string bound_text(const ParetoPoint& point, const VectorX& largest) {
  if (std::isnan(point.lower_bound)) return "-";
  return fmt::format("{} >= {}", letter(static_cast<std::size_t>(point.minimized)),
                     value_text(point.lower_bound, largest[point.minimized]));
}

std::string points_table(const FrontReportData& view) {
  const VectorX max_abs_entry = largest_of(view.front);
  TextTable table{{"point"}, {Align::right}, {}};
  for (std::size_t j = 0; j < view.figures.size(); ++j) {
    table.heading.push_back(letter(j));
    table.align.push_back(Align::right);
  }
  table.heading.insert(table.heading.end(), {"optimality", "bound"});
  table.align.insert(table.align.end(), {Align::left, Align::left});
  for (std::size_t k = 0; k < view.front.points.size(); ++k) {
    const ParetoPoint& point = view.front.points[k];
    std::vector<std::string> row{std::to_string(k + 1)};
    for (Eigen::Index j = 0; j < point.values.size(); ++j) row.push_back(value_text(point.values[j], max_abs_entry[j]));
    row.emplace_back(name_of(point.optimality));
    row.push_back(bound_text(point, max_abs_entry));
    table.rows.push_back(std::move(row));
  }
  return format_table(table);
}

/// A line per free number, a column per point.
std::string numbers_table(const FrontReportData& view) {
  TextTable table{{"free number"}, {Align::left}, {}};
  for (std::size_t k = 0; k < view.front.points.size(); ++k) {
    table.heading.push_back(std::to_string(k + 1));
    table.align.push_back(Align::right);
  }
  for (std::size_t i = 0; i < view.numbers.size(); ++i) {
    std::vector<std::string> row{view.numbers[i].key_path};
    const FreeNumber& number = view.numbers[i];
    for (const ParetoPoint& point : view.front.points)
      row.push_back(value_text(point.report.outcome.x[static_cast<Eigen::Index>(i)],
                               std::max(std::abs(number.lower), std::abs(number.upper))));
    table.rows.push_back(std::move(row));
  }
  return format_table(table);
}

std::string optimality_text(const FrontReportData& view) {
  switch (front_optimality(view.front)) {
    case Optimality::proved_global: return "optimality: proved-best: no design is better than a point in all figures\n";
    case Optimality::local_optimum:
      return "optimality: local-best: the best of what was tried; where there is no bound, better designs may exist\n";
    case Optimality::budget_exhausted:
      if (view.interrupted)
        return fmt::format("optimality: stopped: the points found until it was interrupted, after {:.2g} s\n",
                           *view.interrupted);
      return fmt::format("optimality: stopped: the points found so far, within the {:g} s that all searches may take\n",
                         view.seconds);
    case Optimality::not_optimised: break;
  }
  return "";
}

}  // namespace

std::string front_text(const FrontReportData& view) {
  const ParetoFront& front = view.front;
  if (front.points.empty()) {
    const std::string& reason = front.failure.outcome.reason;
    return fmt::format("{}: no front: {}\n", view.title, reason.empty() ? "no design was found" : reason);
  }
  std::string text = fmt::format("{}: a front of {} design{}{}\n", view.title, front.points.size(),
                                 front.points.size() == 1 ? "" : "s",
                                 view.goals.empty() ? "" : ", all balanced for " + join_goal_names(view.goals));
  text += optimality_text(view) + "\n" + legend(view) + "\n" + points_table(view) + "\n" + numbers_table(view);
  text +=
      fmt::format("\npoint {} is nearest to the least of all figures; --point K shows a point, and writes it with -o\n",
                  find_compromise_point(front) + 1);
  for (const std::string& note : front.notes) text += "note: " + note + "\n";
  return text;
}

}  // namespace balance
