#pragma once
/// A picture as values: panels of lines and marks. gnuplot_script.hpp translates it into a gnuplot script.

#include "balance/interface/files/text_options.hpp"
#include "balance/interface/reports/mechanism_drawing.hpp"
#include "balance/interface/reports/plot_quantities.hpp"
#include "balance/mechanics/results/result.hpp"

#include <cstddef>
#include <string>
#include <vector>

namespace balance::reports {

/// Samples at which an acceleration jumps: its step there is many times the adjacent ones. Such a sample
/// has the value after the jump.
std::vector<Eigen::Index> find_sampled_jumps(const RunResult& result);

/// Points of the values over `x`. At a jump the line first continues to the value before it,
/// so that the step is vertical.
/// @param x one per value, increasing
std::vector<PlotPoint> trace_values(const VectorX& x, const VectorX& values, const std::vector<Eigen::Index>& jumps);

inline constexpr std::size_t max_points_per_line = 4000;  ///< more than a page resolves

/// At most about `max_points` points of a line over x; keeps the minimum and maximum of every interval.
std::vector<PlotPoint> decimate_series(std::vector<PlotPoint> points, std::size_t max_points);

/// At most about `max_points` points of a curve in the plane, including both ends.
std::vector<PlotPoint> decimate_path(std::vector<PlotPoint> points, std::size_t max_points);

/// Style of lines. Styles differ in colour, in lightness where possible, and always in their dashes, so that they can
/// be distinguished in a greyscale print.
struct LineStyle {
  std::string colour;          ///< "#rrggbb"
  std::vector<double> dashes;  ///< lengths of dash, gap, dash, gap, … in line widths; empty: solid
  double width = 1.1;          ///< [pt]
};

/// Colours and dashes repeat, with different periods.
LineStyle make_line_style(std::size_t colour, std::size_t dashes);

/// CIE L* of a colour, from 0 (black) to 100 (white).
double lightness(const std::string& colour);

struct PlotLine {
  std::string label;  ///< in the legend; empty: none
  LineStyle pen;
  std::vector<PlotPoint> points;
};

enum class MarkerShape {
  circle,
  filled_circle,
  dot,  ///< one of thousands
};

struct PlotMarker {
  std::string label;  ///< in the legend; empty: none
  MarkerShape shape = MarkerShape::filled_circle;
  std::string colour;
  std::vector<PlotPoint> points;
};

/// Lines and areas of one style, below the lines of a panel.
struct PlotShape {
  std::string label;  ///< in the legend; empty: none
  LineStyle pen;
  std::string fill;  ///< "#rrggbb"; empty: no area is filled
  double opacity = 1;
  bool is_closed = false;  ///< the last point of each piece is joined to its first
  std::vector<std::vector<PlotPoint>> pieces;
};

struct PlotPanel {
  std::string name;     ///< the quantity as typed
  std::string heading;  ///< above the frame; may be empty
  std::string y_label;
  bool from_zero = false;  ///< values are not negative: the axis begins at 0
  bool legend = true;
  std::vector<PlotShape> shapes;
  std::vector<PlotLine> lines;
  std::vector<PlotMarker> marks;
};

struct Plot {
  std::string title;  ///< above the panels; may be empty
  std::string x_label;
  bool equal_axes = false;   ///< the same scale in both directions, and in all panels
  std::size_t columns = 1;   ///< panels side by side
  double panel_height = 42;  ///< height of a frame without equal axes, unless the page sets it [mm]
  std::vector<PlotPanel> panels;
};

/// One of the runs that a picture overlays.
struct PlotRun {
  std::string label;                     ///< in the legend if there are several runs
  const RunResult* result = nullptr;     ///< not null
  const Mechanism* mechanism = nullptr;  ///< whose run it is; needed for its poses only
};

/// What quantities are drawn over: the time, or the angle of the coordinate that turns at constant speed.
enum class Abscissa { seconds, normalised, angle };

/// Quantities over time, one panel each, with all runs in it.
/// @param units of the axes; SI by default
/// @throws std::invalid_argument if a run lacks a quantity, if a quantity's curves differ in unit, or if nothing turns
/// at constant speed; the message says which
Plot plot_over_time(const std::vector<PlotRun>& runs, const std::vector<std::string>& quantities, VectorView view,
                    Abscissa axis, const specification::SpecUnits& units = {});

/// Amplitudes of the orders of quantities as bars, one panel each: of vectors their largest magnitude, their components,
/// or both.
/// @param highest order
/// @throws std::invalid_argument as results::analyse_orders(), or if a run lacks a quantity; the message names it
Plot plot_orders(const std::vector<PlotRun>& runs, const std::vector<std::string>& quantities, int highest,
                 VectorView view, const specification::SpecUnits& units = {});

/// How paths are drawn.
struct PathView {
  std::string projection = "xy";  ///< one of list_projections()
  int poses = 0;                  ///< of the mechanism, evenly spaced in time: 1 is the start, 2 start and end
  bool is_side_by_side = false;   ///< one panel for each run; else all runs share one
};

inline constexpr int max_poses = 50;  ///< more cannot be distinguished

/// Paths of tool and centre of mass, with start and end marked or, with poses, the mechanism at several times.
/// @throws std::invalid_argument if a planar run has no such projection, or if a run is not its mechanism's
Plot plot_paths(const std::vector<PlotRun>& runs, const PathView& view, const specification::SpecUnits& units = {});

// Phase plane of a path: laws of motion and their limits.

/// Path rate s' over path parameter s: the laws, the maximum velocity curve of the limits, and the switching points,
/// where the path acceleration jumps. The line of a single law shows by its style which limit is active.
/// @throws std::invalid_argument if a run has no phase plane; the message names the run
Plot plot_phase_plane(const std::vector<PlotRun>& runs);

}  // namespace balance::reports
