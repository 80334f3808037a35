#pragma once
/// Where things stand on the page of a picture. Lengths in mm, from the top left corner.

#include "balance/interface/reports/plot.hpp"

#include <string>
#include <string_view>
#include <vector>

namespace balance {

/// A picture in gnuplot's language.
enum class PlotFileFormat { svg, pdf, png };

struct PlotPage {
  PlotFileFormat format = PlotFileFormat::svg;
  double width = 0, height = 0;    ///< [mm]; 0: what suits the picture
  std::string font = "Helvetica";  ///< letters, digits, blanks and hyphens
  double font_size = 9;            ///< [pt]
};

/// The page with its size decided.
/// @throws std::invalid_argument if texts and legends would leave too little for the panels; the message says how much it takes
PlotPage resolve_page_size(const Plot& picture, PlotPage page);

/// A script without any file name: it prints the picture to standard output. The same picture gives the same text.
std::string gnuplot_script(const Plot& picture, const PlotPage& page);

/// A text, visible as in foundation/base/unicode_text.hpp, in the quotes in which gnuplot prints it as it is and nothing in it is a
/// command.
std::string gnuplot_quoted(std::string_view text);

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
