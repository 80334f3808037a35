#pragma once
/// The program gnuplot as a function.

#include "balance/interface/reports/gnuplot_script.hpp"

#include <string>

namespace balance {

// A picture as the bytes of a file.

/// Draws with gnuplot. The same picture and page give the same bytes with the same gnuplot and fonts.
/// @throws SystemError as run_gnuplot
std::string render_plot(const Plot& picture, const PlotPage& page);

/// gnuplot's SVG with its size in mm, the picture's name for readers of the screen and a family of fonts to fall back on.
std::string normalise_svg(std::string svg, const std::string& name, const PlotPage& page);

/// cairo's PDF without the time of day.
std::string remove_pdf_date(std::string pdf);

/// What gnuplot prints when it reads the script. It is found by PATH and started without a shell, its own settings files are
/// not read, and language and time zone are fixed.
/// @throws SystemError if there is no gnuplot, or with what it says if it fails
std::string run_gnuplot(const std::string& script);

}  // namespace balance
