#include "balance/report/plot_layout.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstring>
#include <limits>
#include <stdexcept>

namespace balance {
namespace {

constexpr double mm_per_point = 25.4 / 72;
constexpr double min_frame_width = 15, min_frame_height = 5;  // mm of a frame that still shows something
// of a legend, in font sizes
constexpr double legend_line_length = 2.4, text_gap = 0.6, entry_gap = 1.8;

struct Sizes {
  double em;  ///< font size in mm
  double left() const { return 6.4 * em; }
  double right() const { return 1.4 * em; }
  double above() const { return 0.7 * em; }
  double below() const { return 4.2 * em; }  ///< tics and label of the horizontal axis
  double between() const { return 1.5 * em; }
  double line() const { return 1.45 * em; }
  double title() const { return 1.9 * em; }
};

Sizes sizes_of(const PlotPage& page) { return {page.font_size * mm_per_point}; }

/// About the width of a text in a face without serifs, in font sizes.
double text_width(const std::string& text) {
  double width = 0;
  for (const char c : text) {
    if ((c & 0xc0) == 0x80) continue;  // inside a letter of several bytes
    width += std::strchr(" .,:;'|!iljftr()[]-", c)         ? 0.31
             : std::strchr("mwMW%@", c)                    ? 0.85
             : std::isupper(static_cast<unsigned char>(c)) ? 0.7
                                                           : 0.55;
  }
  return width;
}

std::vector<std::string> labels_of(const PlotPanel& panel) {
  std::vector<std::string> labels;
  for (const PlotLine& line : panel.lines)
    if (!line.label.empty()) labels.push_back(line.label);
  for (const PlotMarker& mark : panel.marks)
    if (!mark.label.empty()) labels.push_back(mark.label);
  return panel.legend ? labels : std::vector<std::string>();
}

double frame_width(const PlotPage& page) { return page.width - sizes_of(page).left() - sizes_of(page).right(); }

/// Entries from the left, on one row if they fit, else in columns; y is from the legend's top.
std::vector<LegendEntryLayout> place_legend(const PlotPanel& panel, const PlotPage& page) {
  const Sizes sizes = sizes_of(page);
  std::vector<double> widths;
  double all = 0, widest = 0;
  for (const std::string& label : labels_of(panel)) {
    widths.push_back((legend_line_length + text_gap + text_width(label) + entry_gap) * sizes.em);
    all += widths.back();
    widest = std::max(widest, widths.back());
  }
  const double room = frame_width(page) + entry_gap * sizes.em;
  const bool one_row = all <= room;
  const std::size_t columns = one_row ? widths.size() : static_cast<std::size_t>(std::max(1.0, room / widest));
  std::vector<LegendEntryLayout> places;
  double x = 0;
  for (std::size_t i = 0; i < widths.size(); ++i) {
    if (!one_row) x = static_cast<double>(i % columns) * widest;
    const double begin = sizes.left() + x, end = begin + legend_line_length * sizes.em;
    const std::size_t row = i / columns;
    places.push_back({begin, end, end + text_gap * sizes.em, (static_cast<double>(row) + 0.5) * sizes.line()});
    x += widths[i];
  }
  return places;
}

double legend_height(const std::vector<LegendEntryLayout>& places, const Sizes& sizes) {
  return places.empty() ? 0 : places.back().y + 0.5 * sizes.line() + 0.4 * sizes.em;
}

/// Everything but the frames.
double other_height(const Plot& picture, const PlotPage& page) {
  const Sizes sizes = sizes_of(page);
  double height = sizes.above() + sizes.below() + (picture.title.empty() ? 0 : sizes.title());
  for (const PlotPanel& panel : picture.panels) height += legend_height(place_legend(panel, page), sizes);
  return height + static_cast<double>(picture.panels.size() - 1) * sizes.between();
}

}  // namespace

AxisRange range_over(const PlotPanel& panel, double PlotPoint::*coordinate) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const PlotLine& line : panel.lines) {
    for (const PlotPoint& point : line.points) {
      if (!std::isfinite(point.*coordinate)) continue;
      low = std::min(low, point.*coordinate);
      high = std::max(high, point.*coordinate);
    }
  }
  return low <= high ? AxisRange{low, high} : AxisRange{0, 1};
}

AxisRange value_range(const PlotPanel& panel) {
  AxisRange range = range_over(panel, &PlotPoint::y);
  if (panel.from_zero) return {0, range.high > 0 ? 1.06 * range.high : 1};
  // What differs by round-off only is a constant and stands in the middle.
  const double size = std::max(std::abs(range.low), std::abs(range.high));
  const double span = range.high - range.low;
  const double spare = span > 1e-6 * size ? 0.06 * span : size > 0 ? 0.2 * size : 1;
  return {range.low - spare, range.high + spare};
}

double default_height(const Plot& picture, const PlotPage& page) {
  const double other = other_height(picture, page);
  if (!picture.equal_axes) return other + picture.panel_height * static_cast<double>(picture.panels.size());
  const AxisRange x = range_over(picture.panels.front(), &PlotPoint::x);
  const AxisRange y = range_over(picture.panels.front(), &PlotPoint::y);
  const double ratio = x.high > x.low ? (y.high - y.low) / (x.high - x.low) : 1;
  return other + frame_width(page) * std::clamp(ratio, 0.4, 1.2);
}

void check_page_size(const Plot& picture, const PlotPage& page) {
  const double width = page.width - frame_width(page) + min_frame_width;
  const double height = other_height(picture, page) + min_frame_height * static_cast<double>(picture.panels.size());
  if (page.width < width || page.height < height)
    throw std::invalid_argument(
        fmt::format("{:g}x{:g} mm is too small for {} with a font of {:g} pt: it takes {:.0f}x{:.0f}", page.width,
                    page.height, picture.panels.size() > 1 ? "these panels" : "this panel", page.font_size,
                    std::ceil(std::max(width, page.width)), std::ceil(std::max(height, page.height))));
}

PageLayout compute_layout(const Plot& picture, const PlotPage& page) {
  const Sizes sizes = sizes_of(page);
  PageLayout layout{.width = page.width, .height = page.height};
  const double frames = (page.height - other_height(picture, page)) / static_cast<double>(picture.panels.size());
  double y = sizes.above();
  layout.title = y + sizes.title() / 2;
  if (!picture.title.empty()) y += sizes.title();
  for (std::size_t i = 0; i < picture.panels.size(); ++i) {
    PanelLayout place;
    place.legend = place_legend(picture.panels[i], page);
    place.left = sizes.left();
    place.right = page.width - sizes.right();
    place.top = y + legend_height(place.legend, sizes);
    for (LegendEntryLayout& entry : place.legend) entry.y += y;
    place.bottom = place.top + frames;
    y = place.bottom + sizes.between();
    layout.panels.push_back(place);
  }
  layout.x_label = layout.panels.back().bottom + 3.2 * sizes.em;
  layout.y_label = 0.9 * sizes.em;
  return layout;
}

}  // namespace balance
