// Paths of tool and centre of mass, and the mechanism that moves along them.

#include "balance/foundation/numerics/extrema.hpp"
#include "balance/interface/reports/mechanism_drawing.hpp"
#include "balance/interface/reports/plot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <utility>

namespace balance::reports {
namespace {

constexpr std::size_t max_listed_times = 4;  // of poses between start and end
constexpr const char* mark_colour = "#30363d";
constexpr const char* ground_colour = "#6b7280";
constexpr std::size_t max_columns = 3;

std::vector<PlotPoint> path_points(const Samples& position, const Projection& projection) {
  std::vector<PlotPoint> points;
  for (Eigen::Index k = 0; k < position.rows(); ++k) {
    Vector3 place = Vector3::Zero();
    place.head(position.cols()) = position.row(k).transpose();
    points.push_back(projection.apply(place));
  }
  return decimate_path(std::move(points), max_points_per_line);
}

/// Mixes a colour with white. @param share of white, from 0 to 1
std::string lighten(const std::string& colour, double share) {
  std::string text = "#";
  for (std::size_t at = 1; at < colour.size(); at += 2) {
    const double channel = std::stoi(colour.substr(at, 2), nullptr, 16);
    text += fmt::format("{:02x}", static_cast<int>(std::lround(channel + share * (255 - channel))));
  }
  return text;
}

// Poses.

/// Colours and widths of the mechanism at one time.
struct PoseStyle {
  LineStyle link;
  double fill_opacity = 0;  ///< 0: nothing is filled, and joints are left out
};

struct Pose {
  Eigen::Index row = 0;  ///< of the run
  PoseStyle style;
  std::string label;
};

/// Nearest samples to evenly spaced times, without repetitions.
std::vector<Eigen::Index> pose_rows(const VectorX& time, int count) {
  std::vector<Eigen::Index> rows;
  const double begin = time[0], end = time[time.size() - 1];
  for (int i = 0; i < count; ++i) {
    const double wanted = count > 1 ? begin + (end - begin) * i / (count - 1) : begin;
    const Eigen::Index nearest = numerics::min_index((time.array() - wanted).abs().matrix());
    if (rows.empty() || rows.back() != nearest) rows.push_back(nearest);
  }
  return rows;
}

/// "0.05 s".
std::string time_text(double time, const files::DisplayUnit& unit) {
  return fmt::format("{:.4g} {}", unit.convert(time), unit.name);
}

/// "t = 0.05 s", "t = 0.02, 0.04 s", or the spacing of many.
std::string times_between(const VectorX& time, const std::vector<Eigen::Index>& rows, const files::DisplayUnit& unit) {
  const std::size_t count = rows.size() - 2;
  if (count > max_listed_times)
    return "every " + time_text((time[rows.back()] - time[rows.front()]) / static_cast<double>(rows.size() - 1), unit);
  std::string list;
  for (std::size_t i = 1; i <= count; ++i)
    list += fmt::format("{}{:.4g}", i > 1 ? ", " : "", unit.convert(time[rows[i]]));
  return fmt::format("t = {} {}", list, unit.name);
}

/// Start and end in lines of their own weight, the poses between them thin. One entry of the legend for each kind.
std::vector<Pose> list_poses(const PlotRun& run, int count, const std::string& colour, const std::string& prefix,
                             const files::DisplayUnit& unit) {
  const VectorX& time = run.result->time;
  const std::vector<Eigen::Index> rows = pose_rows(time, count);
  std::vector<Pose> poses;
  if (time.size() == 1) return {{0, {{colour, {}, 1.8}, 0.18}, prefix + "pose"}};
  for (std::size_t i = 1; i + 1 < rows.size(); ++i) {
    const LineStyle thin{lighten(colour, 0.5), {}, 0.6};
    poses.push_back({rows[i], {thin, 0}, i == 1 ? prefix + times_between(time, rows, unit) : ""});
  }
  const Pose start{rows.front(),
                   {{lighten(colour, 0.4), {}, 1.6}, 0.12},
                   prefix + "start, t = " + time_text(time[rows.front()], unit)};
  const Pose end{rows.back(), {{colour, {}, 1.8}, 0.18}, prefix + "end, t = " + time_text(time[rows.back()], unit)};
  poses.insert(poses.begin(), start);
  if (rows.size() > 1) poses.push_back(end);
  return poses;
}

/// How a part of a pose is drawn; std::nullopt: not at all.
std::optional<PlotShape> shape_of(DrawingPart part, bool is_closed, const PoseStyle& style) {
  const bool is_thin = style.fill_opacity == 0;
  const std::string& colour = style.link.colour;
  PlotShape shape{.pen = style.link, .is_closed = is_closed};
  const LineStyle fine{colour, {}, is_thin ? style.link.width : 0.8};
  switch (part) {
    case DrawingPart::link:
      if (is_closed && !is_thin) shape.fill = colour, shape.opacity = style.fill_opacity;
      break;
    case DrawingPart::mass:
    case DrawingPart::disc:
      shape.pen = fine;
      if (is_closed && !is_thin) shape.fill = colour, shape.opacity = part == DrawingPart::mass ? 0.45 : 0.08;
      break;
    case DrawingPart::joint:
    case DrawingPart::slider:
      if (is_thin && part == DrawingPart::joint) return std::nullopt;
      shape.pen = {colour, {}, is_thin ? style.link.width : 1.0};
      if (!is_thin) shape.fill = "#ffffff";
      break;
    case DrawingPart::tool:
      if (is_thin) return std::nullopt;
      shape.pen = fine;
      shape.fill = colour;
      break;
    default: shape.pen = fine;
  }
  return shape;
}

/// Adds outlines to the panel, those of one part and style as one shape. @param label in the legend, for the links
void add_outlines(std::vector<Outline> outlines, const PoseStyle& style, const std::string& label, PlotPanel& panel) {
  std::stable_sort(outlines.begin(), outlines.end(), [](const Outline& a, const Outline& b) {
    return a.part != b.part ? a.part < b.part : a.is_closed > b.is_closed;
  });
  bool is_labelled = false;
  const Outline* previous = nullptr;
  for (Outline& outline : outlines) {
    const std::optional<PlotShape> shape = shape_of(outline.part, outline.is_closed, style);
    if (!shape) continue;
    const bool is_same =
        previous != nullptr && previous->part == outline.part && previous->is_closed == outline.is_closed;
    if (!is_same) {
      panel.shapes.push_back(*shape);
      if (!is_labelled && outline.part == DrawingPart::link) panel.shapes.back().label = label, is_labelled = true;
    }
    panel.shapes.back().pieces.push_back(outline.points);
    previous = &outline;
  }
  if (!is_labelled && !label.empty()) panel.shapes.push_back({.label = label, .pen = style.link});
}

void add_ground(const PlotRun& run, const Projection& projection, const DrawingScale& scale, PlotPanel& panel) {
  PlotShape closed{.pen = {ground_colour, {}, 0.8}, .fill = "#ffffff", .is_closed = true};
  PlotShape open{.pen = {ground_colour, {}, 0.8}};
  for (Outline& outline : draw_ground(*run.mechanism, *run.result, projection, scale))
    (outline.is_closed ? closed : open).pieces.push_back(std::move(outline.points));
  for (PlotShape* shape : {&open, &closed})
    if (!shape->pieces.empty()) panel.shapes.push_back(std::move(*shape));
}

// Paths.

/// Draws one run into a panel.
class PathPanelBuilder {
 public:
  PathPanelBuilder(const std::vector<PlotRun>& runs, const PathView& view, const specification::SpecUnits& units)
      : runs_(runs),
        view_(view),
        projection_(projection_by_name(view.projection)),
        length_(files::find_display_unit("m", units)),
        time_(files::find_display_unit("s", units)) {
    if (view_.poses == 0) return;
    std::vector<const Mechanism*> mechanisms;
    std::vector<const RunResult*> results;
    for (const PlotRun& run : runs_) {
      if (run.mechanism == nullptr) throw std::invalid_argument(run.label + ": its mechanism is not known");
      mechanisms.push_back(run.mechanism), results.push_back(run.result);
    }
    scale_ = drawing_scale(mechanisms, results, projection_);
  }

  PlotPanel empty_panel() const { return {.name = "path", .y_label = projection_.y_label + bracket_unit(length_)}; }

  std::string x_label() const { return projection_.x_label + bracket_unit(length_); }

  void add_run(std::size_t index, PlotPanel& panel) {
    const PlotRun& run = runs_[index];
    if (run.result->axes < 3 && projection_.is_spatial)
      throw std::invalid_argument(fmt::format("{} is planar: it has no {} {}", run.label,
                                              view_.projection == "isometric" ? "view" : "plane", view_.projection));
    if (view_.poses > 0) add_poses(index, panel);
    if (run.result->com_position.rows() == 1)
      state_centres_.points.push_back(path_points(run.result->com_position, projection_).front());
    add_path("tool", run.result->tool_position, index, 0, panel);
    add_path("centre of mass", run.result->com_position, index, 1, panel);
  }

  /// Converts everything in the panel from metres to the unit of its axes.
  void convert_lengths(PlotPanel& panel) const {
    const auto convert = [&](std::vector<PlotPoint>& points) {
      for (PlotPoint& point : points) point = {length_.convert(point.x), length_.convert(point.y)};
    };
    for (PlotLine& line : panel.lines) convert(line.points);
    for (PlotMarker& mark : panel.marks) convert(mark.points);
    for (PlotShape& shape : panel.shapes)
      for (std::vector<PlotPoint>& piece : shape.pieces) convert(piece);
  }

  /// Marks of the paths' ends, unless poses show them; of a single state its centre of mass.
  void add_ends(PlotPanel& panel) {
    if (view_.poses > 0) {
      if (!state_centres_.points.empty()) panel.marks = {state_centres_};
      state_centres_.points.clear();
      return;
    }
    PlotMarker start{"start", MarkerShape::circle, mark_colour, {}},
        end{"end", MarkerShape::filled_circle, mark_colour, {}};
    for (const PlotLine& line : panel.lines)
      start.points.push_back(line.points.front()), end.points.push_back(line.points.back());
    panel.marks = {start, end};
  }

 private:
  bool is_overlaid() const { return runs_.size() > 1 && !view_.is_side_by_side; }

  void add_poses(std::size_t index, PlotPanel& panel) {
    const PlotRun& run = runs_[index];
    add_ground(run, projection_, scale_, panel);
    const std::string colour = is_overlaid() ? make_line_style(index, index).colour : mark_colour;
    for (const Pose& pose : list_poses(run, view_.poses, colour, is_overlaid() ? run.label + ", " : "", time_))
      add_outlines(draw_pose(*run.mechanism, *run.result, pose.row, projection_, scale_), pose.style, pose.label,
                   panel);
  }

  void add_path(const char* what, const Samples& position, std::size_t run, std::size_t style_index, PlotPanel& panel) {
    if (position.rows() < 2) return;
    const LineStyle pen = make_line_style(is_overlaid() ? run : style_index, style_index);
    const std::string label = is_overlaid() ? fmt::format("{}, {}", runs_[run].label, what) : what;
    panel.lines.push_back({label, pen, path_points(position, projection_)});
  }

  const std::vector<PlotRun>& runs_;
  const PathView& view_;
  Projection projection_;
  files::DisplayUnit length_, time_;
  DrawingScale scale_;
  PlotMarker state_centres_{
      "centre of mass", MarkerShape::circle, make_line_style(1, 0).colour, {}};  ///< of this panel
};

bool has_same_legend(const PlotPanel& a, const PlotPanel& b) {
  const auto labels = [](const PlotPanel& panel) {
    std::vector<std::string> list;
    for (const PlotLine& line : panel.lines) list.push_back(line.label);
    for (const PlotShape& shape : panel.shapes)
      if (!shape.label.empty()) list.push_back(shape.label);
    return list;
  };
  return labels(a) == labels(b);
}

std::size_t column_count(std::size_t panels) {
  if (panels <= max_columns) return panels;
  return panels == 4 ? 2 : max_columns;
}

}  // namespace

Plot plot_paths(const std::vector<PlotRun>& runs, const PathView& view, const specification::SpecUnits& units) {
  PathPanelBuilder builder(runs, view, units);
  Plot picture;
  picture.equal_axes = true;
  picture.x_label = builder.x_label();
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const bool is_new = i == 0 || view.is_side_by_side;
    if (is_new) picture.panels.push_back(builder.empty_panel());
    PlotPanel& panel = picture.panels.back();
    if (view.is_side_by_side && runs.size() > 1) panel.heading = runs[i].label;
    builder.add_run(i, panel);
    if (view.is_side_by_side || i + 1 == runs.size()) builder.add_ends(panel);
  }
  for (PlotPanel& panel : picture.panels) builder.convert_lengths(panel);
  const bool is_shared = std::all_of(picture.panels.begin() + 1, picture.panels.end(), [&](const PlotPanel& panel) {
    return has_same_legend(panel, picture.panels.front());
  });
  for (std::size_t i = 1; i < picture.panels.size(); ++i) picture.panels[i].legend = !is_shared;
  picture.columns = column_count(picture.panels.size());
  return picture;
}

}  // namespace balance::reports
