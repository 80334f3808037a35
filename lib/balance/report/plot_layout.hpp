#pragma once
/// Where things stand on the page of a picture. Lengths in mm, from the top left corner. Private to report.

#include "balance/report/plot_script.hpp"

#include <vector>

namespace balance {

/// Of the entries of a legend: lines with a label, then marks with one.
struct LegendEntryLayout {
  double sample = 0, sample_end = 0;  ///< the piece of line, from the left
  double text = 0;                    ///< where the text begins
  double y = 0;                       ///< middle of the row
};

struct PanelLayout {
  double left = 0, right = 0, top = 0, bottom = 0;  ///< of the frame
  std::vector<LegendEntryLayout> legend;
};

struct PageLayout {
  double width = 0, height = 0;
  double title = 0;    ///< middle of the title's line
  double x_label = 0;  ///< middle of the line below the last panel's tics
  double y_label = 0;  ///< middle of the upright line, from the left
  std::vector<PanelLayout> panels;
};

/// @param page with its size
PageLayout compute_layout(const Plot& picture, const PlotPage& page);

/// The height that leaves each panel its usual height (paths: as much as they need).
double default_height(const Plot& picture, const PlotPage& page);

/// @throws std::invalid_argument if texts and legends leave too little for the panels
void check_page_size(const Plot& picture, const PlotPage& page);

struct AxisRange {
  double low = 0, high = 1;
};

/// Room for all points of a panel, with some to spare.
AxisRange range_over(const PlotPanel& panel, double PlotPoint::*coordinate);

/// Vertical axis of values over time: begins at 0 if they are magnitudes.
AxisRange value_range(const PlotPanel& panel);

}  // namespace balance
