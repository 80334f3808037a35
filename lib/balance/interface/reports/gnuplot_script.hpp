#pragma once
/// Layout of a picture on a page, and its gnuplot script. Lengths in mm, from the top left corner.

#include "balance/interface/reports/plot.hpp"

#include <string>
#include <string_view>
#include <vector>

namespace balance::reports {

/// Format of a picture file.
enum class PlotFileFormat { svg, pdf, png };

struct PlotPage {
  PlotFileFormat format = PlotFileFormat::svg;
  double width = 0, height = 0;    ///< [mm]; 0: chosen to suit the picture
  std::string font = "Helvetica";  ///< font family: letters, digits, blanks and hyphens
  double font_size = 9;            ///< [pt]
};

/// Returns the page with its size resolved.
/// @throws std::invalid_argument if texts and legends leave too little room for the panels; the
/// message gives the minimum size
PlotPage resolve_page_size(const Plot& picture, PlotPage page);

/// Script without file names that prints the picture to standard output. The same picture gives the same text.
std::string gnuplot_script(const Plot& picture, const PlotPage& page);

/// Quotes a text, escaped as in foundation/base/unicode_text.hpp, such that gnuplot prints it literally
/// and executes nothing in it.
std::string gnuplot_quoted(std::string_view text);

/// Layout of a legend entry: first lines with a label, then shapes and marks with one.
struct LegendEntryLayout {
  double sample = 0, sample_end = 0;  ///< ends of the line sample, from the left
  double text = 0;                    ///< beginning of the text
  double y = 0;                       ///< middle of the row
};

/// Layout of a panel. Panels fill rows of Plot::columns from the left.
struct PanelLayout {
  double left = 0, right = 0, top = 0, bottom = 0;  ///< of the frame
  double heading = 0;                               ///< middle of its line
  bool has_x_label = true;                          ///< and numbers on the horizontal axis
  bool has_y_label = true;                          ///< and numbers on the vertical axis
  std::vector<LegendEntryLayout> legend;
};

struct PageLayout {
  double width = 0, height = 0;
  double title = 0;    ///< middle of the title's line
  double y_label = 0;  ///< middle of the vertical label, from the left
  std::vector<PanelLayout> panels;
};

/// @param page with resolved size
PageLayout compute_layout(const Plot& picture, const PlotPage& page);

/// Height that gives each panel its usual height (paths: as much as they need).
double default_height(const Plot& picture, const PlotPage& page);

/// @throws std::invalid_argument if texts and legends leave too little room for the panels
void check_page_size(const Plot& picture, const PlotPage& page);

struct AxisRange {
  double low = 0, high = 1;
};

/// Range of a coordinate over all points of a panel's lines and shapes; 0 to 1 if there are none.
AxisRange range_over(const PlotPanel& panel, double PlotPoint::*coordinate);

/// Range of the vertical axis of values over time, with a margin; begins at 0 for magnitudes.
AxisRange value_range(const PlotPanel& panel);

}  // namespace balance::reports
