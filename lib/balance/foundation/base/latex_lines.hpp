#pragma once
/// Formulas in LaTeX, broken into lines.

#include <string>
#include <vector>

namespace balance {

/// About the width of a line of text in an article, in letters.
inline constexpr double latex_line_width = 46;

/// About the width of a formula, in letters.
double latex_width(const std::string& latex);

/// Lines no wider than the limit, broken at signs as far outside brackets as possible, and between factors where no
/// sign is near; brackets may span lines. Fractions that are wider become quotients in one line. A single name is never
/// broken.
/// @param limit in letters
std::vector<std::string> break_latex(const std::string& formula, double limit = latex_line_width);

/// Displays whose lines may continue on the next page, for a document (amsmath); notebooks know no pages.
std::string with_page_breaks(const std::string& displays);

}  // namespace balance
