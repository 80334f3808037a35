#pragma once
/// A picture as the bytes of a file.

#include "balance/report/plot_script.hpp"

namespace balance {

/// Draws with gnuplot. The same picture and page give the same bytes with the same gnuplot and fonts.
/// @throws SystemError as run_gnuplot
std::string draw_picture(const Picture& picture, const PageOptions& page);

/// gnuplot's SVG with its size in mm, the picture's name for readers of the screen and a family of fonts to fall back on.
std::string finish_svg(std::string svg, const std::string& name, const PageOptions& page);

/// cairo's PDF without the time of day.
std::string finish_pdf(std::string pdf);

}  // namespace balance
