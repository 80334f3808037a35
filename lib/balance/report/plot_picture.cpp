#include "balance/report/plot_picture.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

namespace balance {
namespace {

constexpr std::size_t max_points_per_line = 4000;  // of a line: more than a page resolves
constexpr std::size_t max_curves_per_panel = 300;  // of a panel: more than an eye tells apart

/// "m/s^2" as it is printed.
std::string printed_unit(std::string unit) {
  const std::size_t power = unit.find("^2");
  if (power != std::string::npos) unit.replace(power, 2, "²");
  return unit;
}

std::string axis_label(const std::string& title, const std::string& unit) {
  return unit == "1" ? title : fmt::format("{} [{}]", title, printed_unit(unit));
}

std::string legend_label(const std::string& run, const std::string& curve, bool several_runs) {
  if (!several_runs) return curve;
  return curve.empty() ? run : run + ", " + curve;
}

PlotQuantity quantity_of(const PlotRun& run, const std::string& name, VectorView view) {
  std::optional<PlotQuantity> quantity = find_plot_quantity(*run.result, name, view);
  if (!quantity) throw std::invalid_argument(fmt::format("{} has no {}", run.label, name));
  if (quantity->unit == "mixed")
    throw std::invalid_argument(
        fmt::format("{0} has different units: name one, such as {0}[{1}]", name, quantity->curves.front().label));
  return *std::move(quantity);
}

VectorX abscissa(const RunResult& result, TimeAxis axis) {
  const double duration = result.time.size() > 0 ? result.time[result.time.size() - 1] : 0;
  if (axis == TimeAxis::seconds || duration <= 0) return result.time;
  return result.time / duration;
}

PlotPanel panel_over_time(const std::vector<PlotRun>& runs, const std::string& name, VectorView view, TimeAxis axis) {
  PlotPanel panel;
  panel.name = name;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const PlotQuantity quantity = quantity_of(runs[i], name, view);
    const std::string label = axis_label(quantity.title, quantity.unit);
    if (i == 0) {
      panel.y_label = label;
      panel.from_zero = quantity.not_negative;
    } else if (label != panel.y_label) {
      throw std::invalid_argument(
          fmt::format("{} is {} in {}, {} in {}", name, quantity.unit, runs[i].label, panel.y_label, runs[0].label));
    }
    if (panel.lines.size() + quantity.curves.size() > max_curves_per_panel)
      throw std::invalid_argument(fmt::format(
          "{0} has more than {1} curves, the most that a panel holds: name one, such as {0}[{2}]", name,
          max_curves_per_panel, quantity.curves.front().label.substr(0, quantity.curves.front().label.find(' '))));
    const std::vector<Eigen::Index> jumps = find_sampled_jumps(*runs[i].result);
    for (std::size_t j = 0; j < quantity.curves.size(); ++j) {
      // Colours tell curves apart and dashes runs; where there is one of either, both do.
      const std::size_t both = quantity.curves.size() == 1 ? i : j;
      const LineStyle pen = make_line_style(both, runs.size() == 1 || quantity.curves.size() == 1 ? both : i);
      const PlotCurve& curve = quantity.curves[j];
      panel.lines.push_back(
          {legend_label(runs[i].label, curve.label, runs.size() > 1), pen,
           decimate_series(trace_values(abscissa(*runs[i].result, axis), curve.values, jumps), max_points_per_line)});
    }
  }
  return panel;
}

std::vector<std::string> legend_of(const PlotPanel& panel) {
  std::vector<std::string> labels;
  for (const PlotLine& line : panel.lines) labels.push_back(line.label);
  return labels;
}

/// The columns of a plane's axes. @throws std::invalid_argument
std::pair<Eigen::Index, Eigen::Index> axes_of(const std::string& plane, const PlotRun& run) {
  const std::string axes = std::string("xyz").substr(0, static_cast<std::size_t>(run.result->axes));
  if (plane.size() != 2 || axes.find(plane[0]) == std::string::npos || axes.find(plane[1]) == std::string::npos)
    throw std::invalid_argument(fmt::format("{} is planar: it has no plane {}", run.label, plane));
  return {static_cast<Eigen::Index>(axes.find(plane[0])), static_cast<Eigen::Index>(axes.find(plane[1]))};
}

std::vector<PlotPoint> path_points(const Samples& position, std::pair<Eigen::Index, Eigen::Index> axes) {
  std::vector<PlotPoint> points;
  for (Eigen::Index k = 0; k < position.rows(); ++k)
    points.push_back({position(k, axes.first), position(k, axes.second)});
  return decimate_path(points, max_points_per_line);
}

constexpr const char* mark_colour = "#30363d";

}  // namespace

Plot plot_over_time(const std::vector<PlotRun>& runs, const std::vector<std::string>& quantities, VectorView view,
                    TimeAxis axis) {
  Plot picture;
  picture.x_label = axis == TimeAxis::seconds ? "time [s]" : "time / duration";
  for (const std::string& name : quantities) {
    picture.panels.push_back(panel_over_time(runs, name, view, axis));
    PlotPanel& panel = picture.panels.back();
    // Below a panel with the same legend it would be said twice.
    if (picture.panels.size() > 1) panel.legend = legend_of(panel) != legend_of(*(picture.panels.end() - 2));
  }
  return picture;
}

Plot plot_paths(const std::vector<PlotRun>& runs, const std::string& plane) {
  Plot picture;
  picture.equal_axes = true;
  picture.x_label = fmt::format("{} [m]", plane.substr(0, 1));
  PlotPanel panel{.name = "path", .y_label = fmt::format("{} [m]", plane.substr(1))};
  PlotMarker start{"start", MarkerShape::circle, mark_colour, {}},
      end{"end", MarkerShape::filled_circle, mark_colour, {}};
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const auto axes = axes_of(plane, runs[i]);
    const auto add = [&](const char* what, const Samples& position, std::size_t which) {
      if (position.rows() == 0) return;
      const LineStyle pen = make_line_style(runs.size() == 1 ? which : i, which);
      panel.lines.push_back({legend_label(runs[i].label, what, runs.size() > 1), pen, path_points(position, axes)});
      start.points.push_back(panel.lines.back().points.front());
      end.points.push_back(panel.lines.back().points.back());
    };
    add("tool", runs[i].result->tool_position, 0);
    add("centre of mass", runs[i].result->com_position, 1);
  }
  panel.marks = {start, end};
  picture.panels.push_back(panel);
  return picture;
}

}  // namespace balance
