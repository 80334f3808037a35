#pragma once
/// A picture as values: panels of lines and marks. plot_script.hpp says it to gnuplot.

#include "balance/report/plot_lines.hpp"
#include "balance/report/plot_pen.hpp"
#include "balance/report/plot_quantities.hpp"

#include <string>
#include <vector>

namespace balance {

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

}  // namespace balance
