#include "balance/report/plot_pen.hpp"

#include "balance/base/elementary.hpp"

#include <cmath>

namespace balance {
namespace {

const std::vector<std::string> colours = {"#123a6b", "#d1495b", "#dd9a1f", "#1f8a70", "#7a4fa3", "#6b7280"};

const std::vector<std::vector<double>> patterns = {{},    {8, 3}, {3, 2}, {10, 3, 2, 3}, {14, 4}, {10, 3, 2, 3, 2, 3},
                                                   {4, 5}};

double linear(double s) { return s <= 0.04045 ? s / 12.92 : elementary::pow((s + 0.055) / 1.055, 2.4); }

}  // namespace

LineStyle make_line_style(std::size_t colour, std::size_t dashes) {
  return {colours[colour % colours.size()], patterns[dashes % patterns.size()]};
}

double lightness(const std::string& colour) {
  const auto part = [&](std::size_t at) { return linear(std::stoi(colour.substr(at, 2), nullptr, 16) / 255.0); };
  const double y = 0.2126 * part(1) + 0.7152 * part(3) + 0.0722 * part(5);
  return y > 0.008856 ? 116 * std::cbrt(y) - 16 : 903.3 * y;
}

}  // namespace balance
