#pragma once
/// A picture in gnuplot's language.

#include "balance/report/plot_picture.hpp"

#include <string>
#include <string_view>

namespace balance {

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

/// A text, visible as in base/plain_text.hpp, in the quotes in which gnuplot prints it as it is and nothing in it is a command.
std::string gnuplot_quoted(std::string_view text);

}  // namespace balance
