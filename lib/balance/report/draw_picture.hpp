#pragma once
/// A picture as the bytes of a file.

#include "balance/report/plot_script.hpp"

namespace balance {

/// Draws with gnuplot. The same picture and page give the same bytes with the same gnuplot and fonts.
/// @throws SystemError as run_gnuplot
std::string render_plot(const Plot& picture, const PlotPage& page);

/// gnuplot's SVG with its size in mm, the picture's name for readers of the screen and a family of fonts to fall back on.
std::string normalise_svg(std::string svg, const std::string& name, const PlotPage& page);

/// cairo's PDF without the time of day.
std::string remove_pdf_date(std::string pdf);

}  // namespace balance
