#include "balance/report/plot_phase.hpp"

#include "balance/base/extrema.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace balance {
namespace {

constexpr double max_rate_headroom = 1.4;             // over the fastest law; the ceiling goes on beyond it
constexpr std::size_t max_distinguished_limits = 12;  // that are told apart; more stand in the table of the run
constexpr double phase_height = 75;                   // [mm]
constexpr const char* max_velocity_colour = "#9aa1a9";
constexpr const char* switch_colour = "#30363d";

const PhasePlane& plane_of(const PlotRun& run) {
  const PhasePlane& plane = run.result->phase_plane;
  if (plane.time.size() > 1) return plane;
  throw std::invalid_argument(fmt::format(
      "{} has no phase plane: result files have it of laws that were found and of trajectories with limits; "
      "draw the spec itself, such as spec.yaml:trajectory",
      run.label));
}

PlotPoint point_at(const PhasePlane& plane, double time) {
  const Eigen::Index last = plane.time.size() - 1;
  Eigen::Index k = 1;
  while (k < last && plane.time[k] < time) ++k;
  const double width = plane.time[k] - plane.time[k - 1];
  const double part = width > 0 ? std::clamp((time - plane.time[k - 1]) / width, 0.0, 1.0) : 1;
  const auto mix = [&](const VectorX& values) { return (1 - part) * values[k - 1] + part * values[k]; };
  return {mix(plane.path_parameter), mix(plane.path_rate)};
}

std::vector<PlotPoint> points_between(const PhasePlane& plane, double begin, double end) {
  std::vector<PlotPoint> points{point_at(plane, begin)};
  for (Eigen::Index k = 0; k < plane.time.size(); ++k)
    if (plane.time[k] > begin && plane.time[k] < end) points.push_back({plane.path_parameter[k], plane.path_rate[k]});
  points.push_back(point_at(plane, end));
  return points;
}

/// One line per stretch, one pen and one entry of the legend per limit.
void add_stretches(const PlotRun& run, PlotPanel& panel) {
  std::vector<std::string> limits;
  for (const ActiveLimitInterval& stretch : run.result->optimised_law->active_limits) {
    const std::string limit = stretch.limit.empty() ? "no limit" : stretch.limit;
    const auto known = std::find(limits.begin(), limits.end(), limit);
    const auto index = static_cast<std::size_t>(known - limits.begin());
    const bool is_new = known == limits.end();
    if (is_new) limits.push_back(limit);
    const std::string label = !is_new || index > max_distinguished_limits ? ""
                              : index == max_distinguished_limits         ? "others"
                                                                          : limit;
    const std::size_t pen = std::min(index, max_distinguished_limits);
    panel.lines.push_back(
        {label, make_line_style(pen, pen), points_between(run.result->phase_plane, stretch.begin, stretch.end)});
  }
}

/// What lies below the top, in pieces.
std::vector<std::vector<PlotPoint>> pieces_below(const PhasePlane& plane, double top) {
  std::vector<std::vector<PlotPoint>> pieces;
  const auto cross = [&](Eigen::Index below, Eigen::Index above) -> PlotPoint {
    const double rise = plane.mvc_path_rate[above] - plane.mvc_path_rate[below];
    const double part = std::isfinite(rise) && rise > 0 ? (top - plane.mvc_path_rate[below]) / rise : 0;
    return {
        plane.mvc_path_parameter[below] + part * (plane.mvc_path_parameter[above] - plane.mvc_path_parameter[below]),
        top};
  };
  for (Eigen::Index k = 0; k < plane.mvc_path_rate.size(); ++k) {
    const bool inside = plane.mvc_path_rate[k] <= top, was_inside = k > 0 && plane.mvc_path_rate[k - 1] <= top;
    if (inside && !was_inside) pieces.emplace_back();
    if (inside && !was_inside && k > 0) pieces.back().push_back(cross(k, k - 1));
    if (inside) pieces.back().push_back({plane.mvc_path_parameter[k], plane.mvc_path_rate[k]});
    if (!inside && was_inside) pieces.back().push_back(cross(k - 1, k));
  }
  return pieces;
}

void add_max_velocity_curves(const std::vector<PlotRun>& runs, double top, PlotPanel& panel) {
  for (std::size_t i = 0; i < runs.size(); ++i) {
    LineStyle pen{max_velocity_colour, {6, 3}};
    if (runs.size() > 1) pen = {make_line_style(i, i).colour, {2, 2}};
    std::string label = runs.size() > 1 ? runs[i].label + ", limits" : "largest rate within the limits";
    for (auto& piece : pieces_below(runs[i].result->phase_plane, top)) {
      panel.lines.push_back({label, pen, std::move(piece)});
      label.clear();
    }
  }
}

void add_switches(const std::vector<PlotRun>& runs, PlotPanel& panel) {
  PlotMarker mark{"switch", MarkerShape::circle, switch_colour, {}};
  for (const PlotRun& run : runs)
    if (run.result->optimised_law)
      for (const double time : run.result->optimised_law->switch_times)
        mark.points.push_back(point_at(run.result->phase_plane, time));
  if (!mark.points.empty()) panel.marks.push_back(std::move(mark));
}

}  // namespace

Plot plot_phase_plane(const std::vector<PlotRun>& runs) {
  Plot picture;
  picture.x_label = "part of the path that is behind";
  picture.panel_height = phase_height;
  PlotPanel panel{.name = "phase plane", .y_label = "its rate [1/s]", .from_zero = true};
  double top = 0;
  for (const PlotRun& run : runs) top = std::max(top, max_rate_headroom * max_coefficient(plane_of(run).path_rate));
  add_max_velocity_curves(runs, top, panel);
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const PhasePlane& plane = runs[i].result->phase_plane;
    const bool told = runs[i].result->optimised_law && !runs[i].result->optimised_law->active_limits.empty();
    if (runs.size() == 1 && told)
      add_stretches(runs[i], panel);
    else
      panel.lines.push_back({runs.size() > 1 ? runs[i].label : "law", make_line_style(i, i),
                             points_between(plane, plane.time[0], plane.time[plane.time.size() - 1])});
  }
  add_switches(runs, panel);
  picture.panels.push_back(std::move(panel));
  return picture;
}

}  // namespace balance
