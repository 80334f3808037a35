#pragma once
/// Runs the program gnuplot.

#include "balance/interface/reports/gnuplot_script.hpp"

#include <string>

namespace balance::reports {

// A picture as the bytes of a file.

/// Renders with gnuplot. The same picture and page give the same bytes with the same gnuplot and fonts.
/// @throws SystemError as run_gnuplot
std::string render_plot(const Plot& picture, const PlotPage& page);

/// gnuplot's SVG with its size in mm, the picture's name for screen readers and fallback font families.
std::string normalise_svg(std::string svg, const std::string& name, const PlotPage& page);

/// cairo's PDF with a fixed creation date.
std::string remove_pdf_date(std::string pdf);

/// Returns what gnuplot prints for the script. Finds gnuplot by PATH and starts it without a shell, without its
/// settings files, and with fixed language and time zone.
/// @throws SystemError if there is no gnuplot, or with its message if it fails
std::string run_gnuplot(const std::string& script);

}  // namespace balance::reports
