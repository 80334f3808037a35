// A trade-off as text.

#include "balance/interface/reports/front_sections.hpp"

#include "balance/interface/files/result_group.hpp"
#include "balance/interface/files/text_table.hpp"
#include "balance/interface/reports/conditions_sections.hpp"
#include "balance/interface/reports/design_sections.hpp"
#include "balance/interface/reports/length_bound_sections.hpp"
#include "balance/interface/reports/load_case_sections.hpp"
#include "balance/motion/simulation/run_figure.hpp"
#include "balance/synthesis/design/status_names.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace balance::reports {

using design::Optimality;
using design::ParetoFront;
using design::ParetoPoint;

// A trade-off as an HDF5 file.

namespace {

using Dimension = hdf5::Hdf5Writer::Dimension;

/// One row per point.
Samples rows_of(const ParetoFront& front, Eigen::Index columns, VectorX (*row)(const ParetoPoint&)) {
  Samples rows(static_cast<Eigen::Index>(front.points.size()), columns);
  for (std::size_t k = 0; k < front.points.size(); ++k)
    rows.row(static_cast<Eigen::Index>(k)) = row(front.points[k]).transpose();
  return rows;
}

std::vector<std::string> point_names(const ParetoFront& front) {
  std::vector<std::string> names;
  for (std::size_t k = 0; k < front.points.size(); ++k) names.push_back(std::to_string(k + 1));
  return names;
}

void add_points(hdf5::Hdf5Writer& file, const FrontReportData& view) {
  const ParetoFront& front = view.front;
  if (front.points.empty()) return;
  std::vector<std::string> paths;
  for (const FreeNumber& number : view.numbers) paths.push_back(number.key_path);
  const Dimension point =
      file.add_dimension(hdf5::root_group, {"point", "of the front", "1", {}, {}}, point_names(front));
  const Dimension figure =
      file.add_dimension(hdf5::root_group, {"figure", "figure of the trade-off", "1", {}, {}}, view.figures);
  const Dimension number =
      file.add_dimension(hdf5::root_group, {"free_number", "key path in the spec", "1", {}, {}}, paths);
  const auto figures = static_cast<Eigen::Index>(view.figures.size()),
             numbers = static_cast<Eigen::Index>(paths.size());
  const auto add = [&](const char* name, const char* long_name, std::vector<Dimension> dimensions,
                       const Samples& rows) {
    file.add_variable(hdf5::root_group, {name, long_name, "mixed", std::move(dimensions), {}}, hdf5::entries_of(rows));
  };
  add("value", "figures of the points, SI", {point, figure},
      rows_of(front, figures, [](const ParetoPoint& p) { return p.values; }));
  add("limit", "limits of the other figures; NaN: not limited", {point, figure},
      rows_of(front, figures, [](const ParetoPoint& p) { return p.limits; }));
  add("minimized", "index of the figure that was minimized", {point},
      rows_of(front, 1, [](const ParetoPoint& p) { return VectorX::Constant(1, p.minimized).eval(); }));
  add("lower_bound", "proved lower bound within the limits; NaN: not proved", {point},
      rows_of(front, 1, [](const ParetoPoint& p) { return VectorX::Constant(1, p.lower_bound).eval(); }));
  add("free_numbers", "values of the free numbers, SI; free parameters as written", {point, number},
      rows_of(front, numbers, [](const ParetoPoint& p) { return p.report.outcome.x; }));
  const auto cases = static_cast<Eigen::Index>(front.points.front().report.load_cases.size());
  if (cases == 0) return;
  std::vector<std::string> names;
  for (Eigen::Index k = 0; k < cases; ++k) names.push_back(std::to_string(k + 1));
  const Dimension load_case = file.add_dimension(hdf5::root_group, {"load_case", "of design: for", "1", {}, {}}, names);
  add("free_numbers_in_case", "values of the free numbers in every case, SI; free parameters as written",
      {point, load_case, number}, rows_of(front, cases * numbers, [](const ParetoPoint& p) {
        VectorX values(static_cast<Eigen::Index>(p.report.load_cases.size()) * p.report.outcome.x.size());
        Eigen::Index offset = 0;
        for (const design::LoadCaseReport& one : p.report.load_cases)
          values.segment(offset, one.x.size()) = one.x, offset += one.x.size();
        return values;
      }));
}

}  // namespace

void write_front(const std::string& path, const FrontReportData& view, const files::Provenance& description,
                 const files::WriteOptions& options) {
  write_hdf5_file(path, description, options, [&](hdf5::Hdf5Writer& file) {
    file.set_attribute(hdf5::root_group, "goal", join_goal_names(view.goals));
    file.set_attribute(hdf5::root_group, "optimality", name_of(front_optimality(view.front)));
    file.set_attribute(hdf5::root_group, "stopped", view.front.is_budget_exhausted ? "yes" : "no");
    add_points(file, view);
  });
}

// A trade-off as JSON.

namespace {

Json figures_json(const FrontReportData& view) {
  Json list = Json::array();
  for (std::size_t j = 0; j < view.figures.size(); ++j) {
    Json figure = {{"name", view.figures[j]}, {"unit", view.units[j]}};
    if (j < view.front.anchors.size()) {
      const design::ParetoAnchor& anchor = view.front.anchors[j];
      figure["least"] = anchor.min_value;
      figure["lower_bound"] = anchor.lower_bound;
      figure["optimality"] = name_of(anchor.optimality);
      if (anchor.length_bound && anchor.length_bound->reason.empty())
        figure["coverage"] = length_coverage_text(*anchor.length_bound);
    }
    list.push_back(std::move(figure));
  }
  return list;
}

Json numbers_list(const FrontReportData& view, const VectorX& x) {
  return files::list_json(files::list_indices(view.numbers.size()), [&](std::size_t i) -> Json {
    return {{"path", view.numbers[i].key_path}, {"value", x[static_cast<Eigen::Index>(i)]}};
  });
}

Json point_json(const FrontReportData& view, std::size_t k) {
  const ParetoPoint& point = view.front.points[k];
  Json json = {{"point", k + 1},
               {"values", files::numbers_json(point.values)},
               {"free_numbers", numbers_list(view, point.report.outcome.x)},
               {"status", name_of(point.report.outcome.status)},
               {"optimality", name_of(point.optimality)},
               {"minimized", point.minimized},
               {"limits", files::numbers_json(point.limits)},
               {"lower_bound", point.lower_bound},
               {"gap", point.gap()},
               {"tried", point.report.outcome.search_summary}};
  if (!point.report.load_cases.empty()) add_load_cases(json, point.report);
  return json;
}

}  // namespace

Json front_json(const FrontReportData& view, const std::vector<std::string>& files, const Json& design) {
  const ParetoFront& front = view.front;
  const bool is_empty = front.points.empty();
  const DesignReport& report = is_empty ? front.failure : front.points.front().report;
  Json json = {{"mechanism", view.title}, {"goal", goals_json(view.goals)}};
  json["status"] = name_of(report.outcome.status);
  json["optimality"] = name_of(front_optimality(front));
  json["reason"] = is_empty ? report.outcome.reason : "";
  json["seconds"] = view.seconds;
  json["front"] = {{"figures", figures_json(view)},
                   {"points", files::list_json(files::list_indices(front.points.size()),
                                               [&](std::size_t k) { return point_json(view, k); })},
                   {"middle", is_empty ? Json(nullptr) : Json(find_compromise_point(front) + 1)},
                   {"searches", front.searches},
                   {"stopped", front.is_budget_exhausted}};
  if (!design.is_null()) json["design"] = design;
  json["notes"] = front.notes;
  json["warnings"] = view.warnings;
  json["files"] = files;
  return json;
}

namespace {

/// Relative to a figure's largest value; smaller values are shown as zero.
constexpr double zero_value_tolerance = 1e-12;

std::string value_text(double value, double largest, const files::DisplayUnit& unit) {
  return std::abs(value) <= zero_value_tolerance * largest ? "0" : files::format_number(unit.convert(value));
}

VectorX max_abs_values(const ParetoFront& front) {
  VectorX max_values = VectorX::Zero(front.points.front().values.size());
  for (const ParetoPoint& point : front.points) max_values = max_values.cwiseMax(point.values.cwiseAbs());
  return max_values;
}

/// Names of the figures: a, b, c.
std::string letter(std::size_t j) { return std::string(1, static_cast<char>('a' + j)); }

files::DisplayUnit figure_unit(const FrontReportData& view, std::size_t j, const specification::SpecUnits& units) {
  return files::find_display_unit(view.units[j], units);
}

std::string legend(const FrontReportData& view, const specification::SpecUnits& units) {
  std::string text;
  for (std::size_t j = 0; j < view.figures.size(); ++j) {
    const files::DisplayUnit unit = figure_unit(view, j, units);
    const bool is_si_sum = view.units[j].empty() && files::has_other_units(units);
    text += fmt::format("{}  {}{}", letter(j), view.figures[j], is_si_sum ? " (a sum, in SI)" : bracket_unit(unit));
    const design::ParetoAnchor anchor = j < view.front.anchors.size() ? view.front.anchors[j] : design::ParetoAnchor{};
    if (anchor.optimality == Optimality::proved_global)
      text += fmt::format("; proved minimum {:.6g}", unit.convert(anchor.min_value));
    text += "\n";
  }
  return text;
}

/// "a >= 3.2": lower bound for all designs within the point's limits.
std::string bound_text(const FrontReportData& view, const ParetoPoint& point, const VectorX& largest,
                       const specification::SpecUnits& units) {
  if (std::isnan(point.lower_bound)) return "-";
  const auto j = static_cast<std::size_t>(point.minimized);
  return fmt::format("{} >= {}", letter(j),
                     value_text(point.lower_bound, largest[point.minimized], figure_unit(view, j, units)));
}

/// For which designs bounds over all lengths hold.
std::string coverage_text(const FrontReportData& view) {
  std::string text;
  for (std::size_t j = 0; j < view.front.anchors.size(); ++j)
    if (const auto& bound = view.front.anchors[j].length_bound; bound && bound->reason.empty())
      text +=
          fmt::format("bound of {}: {}, without limits on other figures\n", letter(j), length_coverage_text(*bound));
  return text;
}

std::string points_table(const FrontReportData& view, const files::TextOptions& options) {
  const VectorX max_abs_entry = max_abs_values(view.front);
  files::TextTable table{{"point"}, {files::Align::right}, {}};
  for (std::size_t j = 0; j < view.figures.size(); ++j) {
    table.heading.push_back(letter(j) + bracket_unit(figure_unit(view, j, options.units)));
    table.align.push_back(files::Align::right);
  }
  table.heading.insert(table.heading.end(), {"optimality", "bound"});
  table.align.insert(table.align.end(), {files::Align::left, files::Align::left});
  for (std::size_t k = 0; k < view.front.points.size(); ++k) {
    const ParetoPoint& point = view.front.points[k];
    std::vector<std::string> row{std::to_string(k + 1)};
    for (Eigen::Index j = 0; j < point.values.size(); ++j)
      row.push_back(
          value_text(point.values[j], max_abs_entry[j], figure_unit(view, static_cast<std::size_t>(j), options.units)));
    row.emplace_back(name_of(point.optimality));
    row.push_back(bound_text(view, point, max_abs_entry, options.units));
    table.rows.push_back(std::move(row));
  }
  return format_table(table, options.width);
}

/// One line per free number, one column per point.
std::string numbers_table(const FrontReportData& view, const files::TextOptions& options) {
  files::TextTable table{{"free number", "unit"}, {files::Align::left, files::Align::left}, {}, 2};
  for (std::size_t k = 0; k < view.front.points.size(); ++k) {
    table.heading.push_back(std::to_string(k + 1));
    table.align.push_back(files::Align::right);
  }
  for (std::size_t i = 0; i < view.numbers.size(); ++i) {
    const FreeNumber& number = view.numbers[i];
    const files::DisplayUnit unit = find_number_unit(number.key_path, options);
    std::vector<std::string> row{number.key_path, unit.name};
    for (const ParetoPoint& point : view.front.points)
      row.push_back(value_text(point.report.outcome.x[static_cast<Eigen::Index>(i)],
                               std::max(std::abs(number.lower), std::abs(number.upper)), unit));
    table.rows.push_back(std::move(row));
  }
  remove_empty_units(table);
  return format_table(table, options.width);
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
      return fmt::format("optimality: stopped: the points found within the time limit of {:g} s for all searches\n",
                         view.seconds);
    case Optimality::not_optimised: break;
  }
  return "";
}

}  // namespace

std::string front_text(const FrontReportData& view, const files::TextOptions& options) {
  const ParetoFront& front = view.front;
  if (front.points.empty()) {
    const std::string& reason = front.failure.outcome.reason;
    return fmt::format("{}: no front: {}\n", view.title, reason.empty() ? "no design was found" : reason);
  }
  std::string text = fmt::format("{}: a front of {} design{}{}\n", view.title, front.points.size(),
                                 front.points.size() == 1 ? "" : "s",
                                 view.goals.empty() ? "" : ", all balanced for " + join_goal_names(view.goals));
  text += optimality_text(view) + "\n" + legend(view, options.units) + "\n" + points_table(view, options) +
          coverage_text(view) + "\n" + numbers_table(view, options);
  text += fmt::format(
      "\npoint {} is nearest to the minima of all figures; --point K shows a point and, with -o, writes it\n",
      find_compromise_point(front) + 1);
  for (const std::string& note : front.notes) text += "note: " + note + "\n";
  return files::wrap_lines(text, options.width);
}

namespace {

std::string with_unit(const std::string& name, const std::string& unit) {
  return files::escape_csv_field(unit.empty() ? name : fmt::format("{} [{}]", name, unit));
}

/// A number that follows the load, in one of the load cases.
struct AdaptedNumber {
  std::size_t load_case;
  Eigen::Index number;
};

/// "counterweights.cw.at[0] (case 2)", one load case after the other.
std::vector<std::pair<std::string, AdaptedNumber>> adapted_numbers(const FrontReportData& view) {
  std::vector<std::pair<std::string, AdaptedNumber>> adapted;
  const std::vector<ParetoPoint>& points = view.front.points;
  if (points.empty() || !points.front().report.adaptive) return adapted;
  const DesignReport& report = points.front().report;
  for (std::size_t k = 0; k < report.load_cases.size(); ++k)
    for (const int number : report.adaptive->numbers)
      adapted.emplace_back(fmt::format("{} (case {})", view.numbers[static_cast<std::size_t>(number)].key_path, k + 1),
                           AdaptedNumber{k, number});
  return adapted;
}

}  // namespace

FrontReportData make_front_report_data(const DesignStudyOptions& options, const DesignSpace& space, ParetoFront front) {
  FrontReportData view;
  view.title = space.start.mechanism.name;
  view.goals = options.goals.empty() ? space.start.design.goals : options.goals;
  for (const std::vector<ObjectiveTerm>& terms : space.start.design.front.figures) {
    view.figures.push_back(objective_text(terms));
    view.units.push_back(simulation::objective_unit(terms, space.start.mechanism));
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
  for (const FreeNumber& number : view.numbers) text += "," + files::escape_csv_field(number.key_path);
  for (const auto& [path, adapted] : adapted_numbers(view)) text += "," + files::escape_csv_field(path);
  text += "\n";
  for (std::size_t k = 0; k < view.front.points.size(); ++k) {
    const ParetoPoint& point = view.front.points[k];
    text += fmt::format("{}", k + 1);
    for (const double value : point.values) text += fmt::format(",{:.17g}", value);
    text += fmt::format(",{},{},{:.17g}", name_of(point.optimality),
                        files::escape_csv_field(view.figures[static_cast<std::size_t>(point.minimized)]),
                        point.lower_bound);
    for (const double value : point.report.outcome.x) text += fmt::format(",{:.17g}", value);
    for (const auto& [path, adapted] : adapted_numbers(view))
      text += fmt::format(",{:.17g}", point.report.load_cases[adapted.load_case].x[adapted.number]);
    text += "\n";
  }
  return text;
}

}  // namespace balance::reports
