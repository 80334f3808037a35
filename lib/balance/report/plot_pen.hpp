#pragma once
/// How lines look. Pens differ in colour, in lightness where that goes, and always in their dashes: on a grey printer too
/// each can be told from the others.

#include <cstddef>
#include <string>
#include <vector>

namespace balance {

struct LineStyle {
  std::string colour;          ///< "#rrggbb"
  std::vector<double> dashes;  ///< lengths of dash, gap, dash, gap, … in line widths; solid if there are none
};

/// Colours and dashes repeat, with different periods.
LineStyle make_line_style(std::size_t colour, std::size_t dashes);

/// How light a colour is, from 0 (black) to 100 (white): CIE L*.
double lightness(const std::string& colour);

}  // namespace balance
