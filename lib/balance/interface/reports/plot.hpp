#pragma once
/// A picture as values: panels of lines and marks. gnuplot_script.hpp says it to gnuplot.

#include "balance/interface/reports/plot_quantities.hpp"
#include "balance/mechanics/results/result.hpp"

#include <cstddef>
#include <string>
#include <vector>

namespace balance {

/// From samples to the points of a line in a picture: jumps upright, no more points than a page can show.
struct PlotPoint {
  double x = 0, y = 0;
};

/// Samples at which an acceleration jumps: its step there is many times those around it. The sample holds the value after the jump.
std::vector<Eigen::Index> find_sampled_jumps(const RunResult& result);

/// The values over `x`; at a jump the line first goes on to the value before it, so that the step is upright.
/// @param x one per value, increasing
std::vector<PlotPoint> trace_values(const VectorX& x, const VectorX& values, const std::vector<Eigen::Index>& jumps);

/// At most about `most` points of a line over x; the largest and smallest value of every stretch stay.
std::vector<PlotPoint> decimate_series(std::vector<PlotPoint> points, std::size_t most);

/// At most about `most` points of a curve in the plane, both ends included.
std::vector<PlotPoint> decimate_path(std::vector<PlotPoint> points, std::size_t most);

/// How lines look. Pens differ in colour, in lightness where that goes, and always in their dashes: on a grey printer too
/// each can be told from the others.
struct LineStyle {
  std::string colour;          ///< "#rrggbb"
  std::vector<double> dashes;  ///< lengths of dash, gap, dash, gap, … in line widths; solid if there are none
};

/// Colours and dashes repeat, with different periods.
LineStyle make_line_style(std::size_t colour, std::size_t dashes);

/// How light a colour is, from 0 (black) to 100 (white): CIE L*.
double lightness(const std::string& colour);

struct PlotLine {
  std::string label;  ///< in the legend; empty: not there
  LineStyle pen;
  std::vector<PlotPoint> points;
};

enum class MarkerShape { circle, filled_circle };

struct PlotMarker {
  std::string label;  ///< in the legend; empty: not there
  MarkerShape shape = MarkerShape::filled_circle;
  std::string colour;
  std::vector<PlotPoint> points;
};

struct PlotPanel {
  std::string name;  ///< the quantity as typed
  std::string y_label;
  bool from_zero = false;  ///< its values are not negative: the axis begins at 0
  bool legend = true;
  std::vector<PlotLine> lines;
  std::vector<PlotMarker> marks;
};

struct Plot {
  std::string title;  ///< above the panels; may be empty
  std::string x_label;
  bool equal_axes = false;   ///< a metre is as long upwards as it is to the right
  double panel_height = 42;  ///< of a frame without equal axes, unless the page says otherwise [mm]
  std::vector<PlotPanel> panels;
};

/// One of the runs that a picture overlays.
struct PlotRun {
  std::string label;                  ///< in the legend where there are several
  const RunResult* result = nullptr;  ///< not null
};

enum class TimeAxis { seconds, normalised };

/// Quantities over time, one panel each, with all runs in it.
/// @throws std::invalid_argument if a run lacks a quantity or if a quantity's curves differ in unit; the message says which
Plot plot_over_time(const std::vector<PlotRun>& runs, const std::vector<std::string>& quantities, VectorView view,
                    TimeAxis axis);

/// The ways of tool and centre of mass, start and end marked.
/// @param plane "xy", "xz" or "yz"
/// @throws std::invalid_argument for a plane that a run does not have
Plot plot_paths(const std::vector<PlotRun>& runs, const std::string& plane);

// The phase plane of a path as a picture: laws of motion and what limits leave them.

/// The rate s' over the place s: the laws, the largest rates that limits leave, and where the path's acceleration jumps. The line of
/// one law tells by its pens which limit is active where.
/// @throws std::invalid_argument if a run has no phase plane; the message says which
Plot plot_phase_plane(const std::vector<PlotRun>& runs);

}  // namespace balance
