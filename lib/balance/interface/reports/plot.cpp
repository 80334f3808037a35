#include "balance/interface/reports/plot.hpp"

#include "balance/foundation/base/elementary.hpp"
#include "balance/foundation/numerics/extrema.hpp"
#include "balance/mechanics/results/orders.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace balance::reports {
namespace {

constexpr double jump_slope_ratio =
    6;  // a larger step relative to its neighbours is a jump: smooth steps differ only by the third derivative
constexpr double jump_epsilon = 0.01;              // of the range; smaller steps are round-off
constexpr double invisible_step_tolerance = 1e-4;  // of the range; smaller vertical steps are invisible

bool jumps_at(const VectorX& values, Eigen::Index k, double range) {
  const auto step = [&](Eigen::Index i) {
    return i < 1 || i >= values.size() ? 0.0 : std::abs(values[i] - values[i - 1]);
  };
  const double max_neighbour_step = std::max({step(k - 2), step(k - 1), step(k + 1), step(k + 2)});
  return step(k) > jump_epsilon * range && step(k) > jump_slope_ratio * max_neighbour_step;
}

/// Extrapolates to sample k from the last three samples before it, none of them before the previous jump.
double value_before(const VectorX& values, Eigen::Index k, Eigen::Index first) {
  const Eigen::Index sample_count = std::min<Eigen::Index>(k - first, 3);
  const auto sample_before = [&](Eigen::Index i) { return values[k - i]; };
  if (sample_count == 3) return 3 * sample_before(1) - 3 * sample_before(2) + sample_before(3);
  return sample_count == 2 ? 2 * sample_before(1) - sample_before(2) : sample_before(1);
}

}  // namespace

std::vector<Eigen::Index> find_sampled_jumps(const RunResult& result) {
  std::vector<Eigen::Index> jumps;
  const Samples& accelerations = result.joint_acceleration;
  for (Eigen::Index column = 0; column < accelerations.cols(); ++column) {
    const VectorX values = accelerations.col(column);
    if (values.size() < 4) continue;
    const double range = numerics::max_coefficient(values) - numerics::min_coefficient(values);
    // at the ends the neighbours on one side are too few to distinguish a jump from the motion
    for (Eigen::Index k = 2; k + 1 < values.size(); ++k)
      if (jumps_at(values, k, range)) jumps.push_back(k);
  }
  std::sort(jumps.begin(), jumps.end());
  jumps.erase(std::unique(jumps.begin(), jumps.end()), jumps.end());
  return jumps;
}

std::vector<PlotPoint> trace_values(const VectorX& x, const VectorX& values, const std::vector<Eigen::Index>& jumps) {
  std::vector<PlotPoint> points;
  const double range = values.size() > 0 ? numerics::max_coefficient(values) - numerics::min_coefficient(values) : 0;
  Eigen::Index first = 0;
  auto next = jumps.begin();
  for (Eigen::Index k = 0; k < values.size(); ++k) {
    if (next != jumps.end() && *next == k) {
      const double limit_value = value_before(values, k, first);
      if (std::abs(limit_value - values[k]) > invisible_step_tolerance * range) points.push_back({x[k], limit_value});
      first = k;
      ++next;
    }
    points.push_back({x[k], values[k]});
  }
  return points;
}

std::vector<PlotPoint> decimate_series(std::vector<PlotPoint> points, std::size_t max_points) {
  if (points.size() <= max_points) return points;
  const std::size_t interval_count = std::max<std::size_t>(max_points / 4, 1);
  std::vector<PlotPoint> selected;
  for (std::size_t i = 0; i < interval_count; ++i) {
    const auto begin = points.begin() + static_cast<std::ptrdiff_t>(i * points.size() / interval_count);
    const auto end = points.begin() + static_cast<std::ptrdiff_t>((i + 1) * points.size() / interval_count);
    const auto [low, high] =
        std::minmax_element(begin, end, [](const PlotPoint& a, const PlotPoint& b) { return a.y < b.y; });
    std::vector<std::vector<PlotPoint>::iterator> extremes = {begin, low, high, end - 1};
    std::sort(extremes.begin(), extremes.end());
    extremes.erase(std::unique(extremes.begin(), extremes.end()), extremes.end());
    for (const auto extreme : extremes) selected.push_back(*extreme);
  }
  return selected;
}

std::vector<PlotPoint> decimate_path(std::vector<PlotPoint> points, std::size_t max_points) {
  if (points.size() <= max_points || max_points < 2) return points;
  std::vector<PlotPoint> selected;
  for (std::size_t i = 0; i < max_points; ++i) selected.push_back(points[i * (points.size() - 1) / (max_points - 1)]);
  return selected;
}

namespace {

const std::vector<std::string> colours = {"#123a6b", "#d1495b", "#dd9a1f", "#1f8a70", "#7a4fa3", "#6b7280"};

const std::vector<std::vector<double>> patterns = {{},    {8, 3}, {3, 2}, {10, 3, 2, 3}, {14, 4}, {10, 3, 2, 3, 2, 3},
                                                   {4, 5}};

double linear(double s) { return s <= 0.04045 ? s / 12.92 : elementary::pow((s + 0.055) / 1.055, 2.4); }

}  // namespace

LineStyle make_line_style(std::size_t colour, std::size_t dashes) {
  return {colours[colour % colours.size()], patterns[dashes % patterns.size()]};
}

double lightness(const std::string& colour) {
  const auto channel = [&](std::size_t at) { return linear(std::stoi(colour.substr(at, 2), nullptr, 16) / 255.0); };
  const double y = 0.2126 * channel(1) + 0.7152 * channel(3) + 0.0722 * channel(5);
  return y > 0.008856 ? 116 * std::cbrt(y) - 16 : 903.3 * y;
}

namespace {

constexpr double max_rate_headroom = 1.4;             // over the fastest law; the limit curve is cut off above
constexpr std::size_t max_distinguished_limits = 12;  // with a style of their own; the table of the run has all
constexpr double phase_height = 75;                   // [mm]
constexpr const char* max_velocity_colour = "#9aa1a9";
constexpr const char* switch_colour = "#30363d";

const trajectory::PhasePlane& plane_of(const PlotRun& run) {
  const trajectory::PhasePlane& plane = run.result->phase_plane;
  if (plane.time.size() > 1) return plane;
  throw std::invalid_argument(fmt::format(
      "{} has no phase plane: result files have one for laws that were found and for trajectories with limits; "
      "draw the spec itself, such as spec.yaml:trajectory",
      run.label));
}

PlotPoint point_at(const trajectory::PhasePlane& plane, double time) {
  const Eigen::Index last = plane.time.size() - 1;
  Eigen::Index k = 1;
  while (k < last && plane.time[k] < time) ++k;
  const double width = plane.time[k] - plane.time[k - 1];
  const double fraction = width > 0 ? std::clamp((time - plane.time[k - 1]) / width, 0.0, 1.0) : 1;
  const auto interpolate = [&](const VectorX& values) { return (1 - fraction) * values[k - 1] + fraction * values[k]; };
  return {interpolate(plane.path_parameter), interpolate(plane.path_rate)};
}

std::vector<PlotPoint> points_between(const trajectory::PhasePlane& plane, double begin, double end) {
  std::vector<PlotPoint> points{point_at(plane, begin)};
  for (Eigen::Index k = 0; k < plane.time.size(); ++k)
    if (plane.time[k] > begin && plane.time[k] < end) points.push_back({plane.path_parameter[k], plane.path_rate[k]});
  points.push_back(point_at(plane, end));
  return points;
}

/// One line per interval, one style and one legend entry per limit.
void add_active_limits(const PlotRun& run, PlotPanel& panel) {
  std::vector<std::string> limits;
  for (const trajectory::ActiveLimitInterval& interval : run.result->optimised_law->active_limits) {
    const std::string limit = interval.limit.empty() ? "no limit" : interval.limit;
    const auto match = std::find(limits.begin(), limits.end(), limit);
    const auto index = static_cast<std::size_t>(match - limits.begin());
    const bool is_new = match == limits.end();
    if (is_new) limits.push_back(limit);
    const std::string label = !is_new || index > max_distinguished_limits ? ""
                              : index == max_distinguished_limits         ? "others"
                                                                          : limit;
    const std::size_t pen = std::min(index, max_distinguished_limits);
    panel.lines.push_back(
        {label, make_line_style(pen, pen), points_between(run.result->phase_plane, interval.begin, interval.end)});
  }
}

/// Pieces of the maximum velocity curve below a rate.
std::vector<std::vector<PlotPoint>> pieces_below(const trajectory::PhasePlane& plane, double max_rate) {
  std::vector<std::vector<PlotPoint>> pieces;
  const auto interpolate_crossing = [&](Eigen::Index below, Eigen::Index above) -> PlotPoint {
    const double rise = plane.mvc_path_rate[above] - plane.mvc_path_rate[below];
    const double fraction = std::isfinite(rise) && rise > 0 ? (max_rate - plane.mvc_path_rate[below]) / rise : 0;
    return {plane.mvc_path_parameter[below] +
                fraction * (plane.mvc_path_parameter[above] - plane.mvc_path_parameter[below]),
            max_rate};
  };
  for (Eigen::Index k = 0; k < plane.mvc_path_rate.size(); ++k) {
    const bool is_below = plane.mvc_path_rate[k] <= max_rate,
               was_below = k > 0 && plane.mvc_path_rate[k - 1] <= max_rate;
    if (is_below && !was_below) pieces.emplace_back();
    if (is_below && !was_below && k > 0) pieces.back().push_back(interpolate_crossing(k, k - 1));
    if (is_below) pieces.back().push_back({plane.mvc_path_parameter[k], plane.mvc_path_rate[k]});
    if (!is_below && was_below) pieces.back().push_back(interpolate_crossing(k - 1, k));
  }
  return pieces;
}

void add_max_velocity_curves(const std::vector<PlotRun>& runs, double max_rate, PlotPanel& panel) {
  for (std::size_t i = 0; i < runs.size(); ++i) {
    LineStyle pen{max_velocity_colour, {6, 3}};
    if (runs.size() > 1) pen = {make_line_style(i, i).colour, {2, 2}};
    std::string label = runs.size() > 1 ? runs[i].label + ", limits" : "largest rate within the limits";
    for (auto& piece : pieces_below(runs[i].result->phase_plane, max_rate)) {
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
  picture.x_label = "fraction of the path covered";
  picture.panel_height = phase_height;
  PlotPanel panel{.name = "phase plane", .y_label = "its rate [1/s]", .from_zero = true};
  double max_rate = 0;
  for (const PlotRun& run : runs)
    max_rate = std::max(max_rate, max_rate_headroom * numerics::max_coefficient(plane_of(run).path_rate));
  add_max_velocity_curves(runs, max_rate, panel);
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const trajectory::PhasePlane& plane = runs[i].result->phase_plane;
    const bool has_active_limits =
        runs[i].result->optimised_law && !runs[i].result->optimised_law->active_limits.empty();
    if (runs.size() == 1 && has_active_limits)
      add_active_limits(runs[i], panel);
    else
      panel.lines.push_back({runs.size() > 1 ? runs[i].label : "law", make_line_style(i, i),
                             points_between(plane, plane.time[0], plane.time[plane.time.size() - 1])});
  }
  add_switches(runs, panel);
  picture.panels.push_back(std::move(panel));
  return picture;
}

namespace {

constexpr std::size_t max_curves_per_panel = 300;  // more than an eye distinguishes

/// "m/s^2" for print.
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

PlotQuantity convert(PlotQuantity quantity, const specification::SpecUnits& units) {
  const files::DisplayUnit unit = files::find_display_unit(quantity.unit, units);
  if (unit.name.empty()) return quantity;
  quantity.unit = unit.name;
  for (PlotCurve& curve : quantity.curves) curve.values /= unit.factor;
  return quantity;
}

/// Angle of the coordinate that turns at constant speed.
VectorX turning_angle(const RunResult& result) {
  const std::string name = results::find_uniform_turning(result).coordinate;
  const auto coordinate = std::find(result.coordinate_names.begin(), result.coordinate_names.end(), name);
  return result.joint_position.col(coordinate - result.coordinate_names.begin());
}

VectorX abscissa(const RunResult& result, Abscissa axis, const specification::SpecUnits& units) {
  const double duration = result.time.size() > 0 ? result.time[result.time.size() - 1] : 0;
  if (axis == Abscissa::angle) return turning_angle(result) / units.angle;
  if (axis == Abscissa::seconds || duration <= 0) return result.time / units.time;
  return result.time / duration;
}

/// The mean over whole turns, whose last sample repeats the first.
PlotLine make_mean_line(const PlotLine& line, const VectorX& values) {
  const double mean = values.head(values.size() - 1).mean();
  PlotLine level{line.label.empty() ? "mean" : line.label + ", mean", line.pen, {}};
  level.pen.dashes = {2, 2};
  for (const PlotPoint& point : {line.points.front(), line.points.back()}) level.points.push_back({point.x, mean});
  return level;
}

PlotPanel panel_over_time(const std::vector<PlotRun>& runs, const std::string& name, VectorView view, Abscissa axis,
                          const specification::SpecUnits& units) {
  PlotPanel panel;
  panel.name = name;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const PlotQuantity quantity = convert(quantity_of(runs[i], name, view), units);
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
      // colours distinguish curves and dashes distinguish runs; if there is only one of either, both vary
      const std::size_t style_index = quantity.curves.size() == 1 ? i : j;
      const LineStyle pen =
          make_line_style(style_index, runs.size() == 1 || quantity.curves.size() == 1 ? style_index : i);
      const PlotCurve& curve = quantity.curves[j];
      panel.lines.push_back({legend_label(runs[i].label, curve.label, runs.size() > 1), pen,
                             decimate_series(trace_values(abscissa(*runs[i].result, axis, units), curve.values, jumps),
                                             max_points_per_line)});
      // in a turning-moment diagram, areas between effort and mean are the energy that the speed takes up
      if (axis == Abscissa::angle && quantity.is_effort && quantity.curves.size() == 1)
        panel.lines.push_back(make_mean_line(panel.lines.back(), curve.values));
    }
  }
  return panel;
}

std::vector<std::string> legend_of(const PlotPanel& panel) {
  std::vector<std::string> labels;
  for (const PlotLine& line : panel.lines) labels.push_back(line.label);
  return labels;
}

}  // namespace

Plot plot_over_time(const std::vector<PlotRun>& runs, const std::vector<std::string>& quantities, VectorView view,
                    Abscissa axis, const specification::SpecUnits& units) {
  Plot picture;
  picture.x_label = axis == Abscissa::seconds      ? "time" + bracket_unit(files::find_display_unit("s", units))
                    : axis == Abscissa::normalised ? "time / duration"
                                                   : results::find_uniform_turning(*runs[0].result).coordinate +
                                                         bracket_unit(files::find_display_unit("rad", units));
  for (const std::string& name : quantities) {
    picture.panels.push_back(panel_over_time(runs, name, view, axis, units));
    PlotPanel& panel = picture.panels.back();
    // the panel above may have the same legend
    if (picture.panels.size() > 1) panel.legend = legend_of(panel) != legend_of(*(picture.panels.end() - 2));
  }
  return picture;
}

}  // namespace balance::reports
