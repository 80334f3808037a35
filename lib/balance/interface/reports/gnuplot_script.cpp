#include "balance/interface/reports/gnuplot_script.hpp"

#include "balance/foundation/base/elementary.hpp"
#include "balance/foundation/base/unicode_text.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstring>
#include <limits>
#include <stdexcept>

namespace balance::reports {
namespace {

constexpr double mm_per_point = 25.4 / 72;
constexpr double min_frame_width = 15, min_frame_height = 5;  // [mm] minimum size of a useful frame
// lengths in a legend, in font sizes
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
  double heading() const { return 1.6 * em; }
  double x_label() const { return 3.2 * em; }     ///< from the frame to the middle of the axis label
  double column_gap() const { return 2.2 * em; }  ///< room for half a number of the horizontal axis
};

Sizes sizes_of(const PlotPage& page) { return {page.font_size * mm_per_point}; }

/// Approximate width of a text in a sans-serif font, in font sizes.
double text_width(const std::string& text) {
  double width = 0;
  for (const char c : text) {
    if ((c & 0xc0) == 0x80) continue;  // continuation byte of a character
    width += std::strchr(" .,:;'|!iljftr()[]-", c)         ? 0.31
             : std::strchr("mwMW%@=", c)                   ? 0.85
             : std::isdigit(static_cast<unsigned char>(c)) ? 0.64
             : std::isupper(static_cast<unsigned char>(c)) ? 0.7
                                                           : 0.55;
  }
  return width;
}

std::vector<std::string> labels_of(const PlotPanel& panel) {
  std::vector<std::string> labels;
  for (const PlotLine& line : panel.lines)
    if (!line.label.empty()) labels.push_back(line.label);
  for (const PlotShape& shape : panel.shapes)
    if (!shape.label.empty()) labels.push_back(shape.label);
  for (const PlotMarker& mark : panel.marks)
    if (!mark.label.empty()) labels.push_back(mark.label);
  return panel.legend ? labels : std::vector<std::string>();
}

double full_width(const PlotPage& page) { return page.width - sizes_of(page).left() - sizes_of(page).right(); }

double frame_width(const Plot& picture, const PlotPage& page) {
  const auto columns = static_cast<double>(picture.columns);
  return (full_width(page) - (columns - 1) * sizes_of(page).column_gap()) / columns;
}

/// Places entries from the left, in one row if they fit, else in columns; y is relative to the legend's top.
std::vector<LegendEntryLayout> place_legend(const PlotPanel& panel, double left, double width, const Sizes& sizes) {
  std::vector<double> widths;
  double total_width = 0, max_width = 0;
  for (const std::string& label : labels_of(panel)) {
    widths.push_back((legend_line_length + text_gap + text_width(label) + entry_gap) * sizes.em);
    total_width += widths.back();
    max_width = std::max(max_width, widths.back());
  }
  const double available_width = width + entry_gap * sizes.em;
  const bool is_one_row = total_width <= available_width;
  const std::size_t columns =
      is_one_row ? widths.size() : static_cast<std::size_t>(std::max(1.0, available_width / max_width));
  std::vector<LegendEntryLayout> layouts;
  double x = 0;
  for (std::size_t i = 0; i < widths.size(); ++i) {
    if (!is_one_row) x = static_cast<double>(i % columns) * max_width;
    const double begin = left + x, end = begin + legend_line_length * sizes.em;
    const std::size_t row = i / columns;
    layouts.push_back({begin, end, end + text_gap * sizes.em, (static_cast<double>(row) + 0.5) * sizes.line()});
    x += widths[i];
  }
  return layouts;
}

double legend_height(const std::vector<LegendEntryLayout>& layouts, const Sizes& sizes) {
  return layouts.empty() ? 0 : layouts.back().y + 0.5 * sizes.line() + 0.4 * sizes.em;
}

std::size_t row_count(const Plot& picture) { return (picture.panels.size() + picture.columns - 1) / picture.columns; }

/// A legend that all panels share spans the page, others their panel.
std::vector<LegendEntryLayout> panel_legend(const Plot& picture, std::size_t index, const PlotPage& page) {
  const Sizes sizes = sizes_of(page);
  const bool is_shared = index == 0 && std::none_of(picture.panels.begin() + 1, picture.panels.end(),
                                                    [](const PlotPanel& panel) { return panel.legend; });
  const double width = frame_width(picture, page),
               x = static_cast<double>(index % picture.columns) * (width + sizes.column_gap());
  return place_legend(picture.panels[index], sizes.left() + x, is_shared ? full_width(page) : width, sizes);
}

/// Height of legends and headings above the frames of a row.
double height_above(const Plot& picture, std::size_t row, const PlotPage& page) {
  const Sizes sizes = sizes_of(page);
  double legend = 0;
  bool has_heading = false;
  for (std::size_t i = row * picture.columns; i < std::min((row + 1) * picture.columns, picture.panels.size()); ++i) {
    legend = std::max(legend, legend_height(panel_legend(picture, i, page), sizes));
    has_heading = has_heading || !picture.panels[i].heading.empty();
  }
  return legend + (has_heading ? sizes.heading() : 0);
}

/// Between rows of panels: those of one column share their horizontal axis.
double height_between(const Plot& picture, const Sizes& sizes) {
  return picture.columns == 1 ? sizes.between() : sizes.below();
}

/// Height of everything but the frames.
double fixed_height(const Plot& picture, const PlotPage& page) {
  const Sizes sizes = sizes_of(page);
  double total = sizes.above() + sizes.below() + (picture.title.empty() ? 0 : sizes.title());
  for (std::size_t row = 0; row < row_count(picture); ++row) total += height_above(picture, row, page);
  return total + static_cast<double>(row_count(picture) - 1) * height_between(picture, sizes);
}

/// Extends a range by the finite coordinates of points.
void extend(AxisRange& range, const std::vector<PlotPoint>& points, double PlotPoint::*coordinate) {
  for (const PlotPoint& point : points) {
    if (!std::isfinite(point.*coordinate)) continue;
    range.low = std::min(range.low, point.*coordinate);
    range.high = std::max(range.high, point.*coordinate);
  }
}

constexpr double infinity = std::numeric_limits<double>::infinity();

void extend(AxisRange& range, const PlotPanel& panel, double PlotPoint::*coordinate) {
  for (const PlotLine& line : panel.lines) extend(range, line.points, coordinate);
  for (const PlotMarker& mark : panel.marks) extend(range, mark.points, coordinate);
  for (const PlotShape& shape : panel.shapes)
    for (const std::vector<PlotPoint>& piece : shape.pieces) extend(range, piece, coordinate);
}

/// Range over all panels, which share their scale.
AxisRange common_range(const Plot& picture, double PlotPoint::*coordinate) {
  AxisRange range{infinity, -infinity};
  for (const PlotPanel& panel : picture.panels) extend(range, panel, coordinate);
  return range.low <= range.high ? range : AxisRange{0, 1};
}

}  // namespace

AxisRange range_over(const PlotPanel& panel, double PlotPoint::*coordinate) {
  AxisRange range{infinity, -infinity};
  extend(range, panel, coordinate);
  return range.low <= range.high ? range : AxisRange{0, 1};
}

AxisRange value_range(const PlotPanel& panel) {
  AxisRange range = range_over(panel, &PlotPoint::y);
  if (panel.from_zero) return {0, range.high > 0 ? 1.06 * range.high : 1};
  // values that differ by round-off only are a constant, drawn in the middle
  const double size = std::max(std::abs(range.low), std::abs(range.high));
  const double span = range.high - range.low;
  const double margin = span > 1e-6 * size ? 0.06 * span : size > 0 ? 0.2 * size : 1;
  return {range.low - margin, range.high + margin};
}

double default_height(const Plot& picture, const PlotPage& page) {
  const double fixed = fixed_height(picture, page);
  const auto rows = static_cast<double>(row_count(picture));
  if (!picture.equal_axes) return fixed + picture.panel_height * rows;
  const AxisRange x = common_range(picture, &PlotPoint::x), y = common_range(picture, &PlotPoint::y);
  const double ratio = x.high > x.low ? (y.high - y.low) / (x.high - x.low) : 1;
  return fixed + rows * frame_width(picture, page) * std::clamp(ratio, 0.4, 1.2);
}

void check_page_size(const Plot& picture, const PlotPage& page) {
  const double width =
      page.width + static_cast<double>(picture.columns) * (min_frame_width - frame_width(picture, page));
  const double height = fixed_height(picture, page) + min_frame_height * static_cast<double>(row_count(picture));
  if (page.width < width || page.height < height)
    throw std::invalid_argument(
        fmt::format("{:g}x{:g} mm is too small for {} with a font of {:g} pt: it takes {:.0f}x{:.0f}", page.width,
                    page.height, picture.panels.size() > 1 ? "these panels" : "this panel", page.font_size,
                    std::ceil(std::max(width, page.width)), std::ceil(std::max(height, page.height))));
}

PageLayout compute_layout(const Plot& picture, const PlotPage& page) {
  const Sizes sizes = sizes_of(page);
  PageLayout layout{.width = page.width, .height = page.height};
  const double height = (page.height - fixed_height(picture, page)) / static_cast<double>(row_count(picture));
  const double width = frame_width(picture, page);
  double y = sizes.above();
  layout.title = y + sizes.title() / 2;
  if (!picture.title.empty()) y += sizes.title();
  for (std::size_t i = 0; i < picture.panels.size(); ++i) {
    const std::size_t column = i % picture.columns, row = i / picture.columns;
    const double above = height_above(picture, row, page);
    PanelLayout panel_layout;
    panel_layout.legend = panel_legend(picture, i, page);
    panel_layout.left = sizes.left() + static_cast<double>(column) * (width + sizes.column_gap());
    panel_layout.right = panel_layout.left + width;
    panel_layout.top = y + above;
    panel_layout.bottom = panel_layout.top + height;
    panel_layout.heading = panel_layout.top - sizes.heading() / 2;
    panel_layout.has_x_label = picture.columns > 1 || i + 1 == picture.panels.size();
    panel_layout.has_y_label = column == 0;
    for (LegendEntryLayout& entry : panel_layout.legend) entry.y += y;
    if (column + 1 == picture.columns) y = panel_layout.bottom + height_between(picture, sizes);
    layout.panels.push_back(panel_layout);
  }
  layout.y_label = 0.9 * sizes.em;
  return layout;
}

namespace {

constexpr double points_per_mm = 72 / 25.4;
constexpr double png_per_point = 300.0 / 72;    // 300 pixels per inch
constexpr double cairo_font_scale = 72.0 / 96;  // gnuplot's cairo terminals take a point for 1/72 of 96 pixels
constexpr int first_legend_label = 5;           // after those of title, axes and heading
constexpr const char* grey = "#9aa1a9";
constexpr const char* pale = "#e3e6ea";

std::string terminal(const PlotPage& page) {
  const double width = page.width * points_per_mm, height = page.height * points_per_mm;
  const std::string font = fmt::format("font '{},{:g}'", page.font, page.font_size);
  switch (page.format) {
    case PlotFileFormat::svg:
      return fmt::format("svg noenhanced size {:.0f},{:.0f} {} butt background rgb 'white'", width, height, font);
    case PlotFileFormat::pdf:
      return fmt::format(
          "pdfcairo noenhanced color size {:.4f}cm,{:.4f}cm {} fontscale {:g} linewidth 2 butt dashlength 2",
          page.width / 10, page.height / 10, font, cairo_font_scale);
    case PlotFileFormat::png: break;
  }
  return fmt::format(
      "pngcairo noenhanced color size {:.0f},{:.0f} {} fontscale {:g} linewidth {:g} pointscale {:g} butt dashlength 2",
      width * png_per_point, height * png_per_point, font, cairo_font_scale * png_per_point, png_per_point,
      png_per_point);
}

std::string dash_type(const LineStyle& pen) {
  return pen.dashes.empty() ? "solid" : fmt::format("({})", fmt::join(pen.dashes, ","));
}

std::string data_name(std::size_t panel, const char* kind, std::size_t index) {
  return fmt::format("$panel{}_{}{}", panel + 1, kind, index + 1);
}

std::string data_block(const std::string& name, const std::vector<PlotPoint>& points) {
  std::string text = name + " << end_of_data\n";
  for (const PlotPoint& point : points) text += fmt::format("{:.9g} {:.9g}\n", point.x, point.y);
  return text + "end_of_data\n";
}

/// Pieces are separated by empty lines.
std::string data_block(const std::string& name, const PlotShape& shape) {
  std::string text = name + " << end_of_data\n";
  for (const std::vector<PlotPoint>& piece : shape.pieces) {
    for (const PlotPoint& point : piece) text += fmt::format("{:.9g} {:.9g}\n", point.x, point.y);
    if (shape.is_closed && !piece.empty()) text += fmt::format("{:.9g} {:.9g}\n", piece[0].x, piece[0].y);
    text += "\n";
  }
  return text + "end_of_data\n";
}

std::string data_blocks(const PlotPanel& panel, std::size_t index) {
  std::string text;
  for (std::size_t i = 0; i < panel.lines.size(); ++i)
    text += data_block(data_name(index, "line", i), panel.lines[i].points);
  for (std::size_t i = 0; i < panel.marks.size(); ++i)
    text += data_block(data_name(index, "mark", i), panel.marks[i].points);
  for (std::size_t i = 0; i < panel.shapes.size(); ++i)
    text += data_block(data_name(index, "shape", i), panel.shapes[i]);
  return text;
}

std::string stroke(const LineStyle& pen) {
  return fmt::format("linewidth {:g} linecolor rgb '{}' dashtype {}", pen.width, pen.colour, dash_type(pen));
}

std::string stroke(const PlotMarker& mark) {
  return fmt::format("pointtype {} pointsize {} linewidth 1 linecolor rgb '{}'",
                     mark.shape == MarkerShape::circle ? 6 : 7, mark.shape == MarkerShape::dot ? 0.15 : 0.6,
                     mark.colour);
}

std::string plot_command(const PlotPanel& panel, std::size_t index) {
  std::vector<std::string> parts;
  for (std::size_t i = 0; i < panel.shapes.size(); ++i) {
    const PlotShape& shape = panel.shapes[i];
    if (shape.pieces.empty()) continue;
    const std::string name = data_name(index, "shape", i);
    if (!shape.fill.empty())
      parts.push_back(
          fmt::format("{} with filledcurves closed fillcolor rgb '{}' fillstyle {} noborder", name, shape.fill,
                      shape.opacity < 1 ? fmt::format("transparent solid {:g}", shape.opacity) : "solid 1"));
    parts.push_back(fmt::format("{} with lines {}", name, stroke(shape.pen)));
  }
  for (std::size_t i = 0; i < panel.lines.size(); ++i)
    parts.push_back(fmt::format("{} with lines {}", data_name(index, "line", i), stroke(panel.lines[i].pen)));
  for (std::size_t i = 0; i < panel.marks.size(); ++i) {
    const std::string name = data_name(index, "mark", i);
    // a ring is white inside: the line that it marks does not show through
    if (panel.marks[i].shape == MarkerShape::circle)
      parts.push_back(name + " with points pointtype 7 pointsize 0.6 linecolor rgb 'white'");
    parts.push_back(fmt::format("{} with points {}", name, stroke(panel.marks[i])));
  }
  return fmt::format("plot {}\n", fmt::join(parts, ", \\\n     "));
}

std::string margins(const PanelLayout& panel_layout, const PageLayout& page) {
  return fmt::format(
      "set lmargin at screen {:.6f}\nset rmargin at screen {:.6f}\nset tmargin at screen {:.6f}\n"
      "set bmargin at screen {:.6f}\n",
      panel_layout.left / page.width, panel_layout.right / page.width, 1 - panel_layout.top / page.height,
      1 - panel_layout.bottom / page.height);
}

/// Enlarges both ranges about their middle to the same scale, such that the points fit into the frame.
void equalise_axes(AxisRange& x, AxisRange& y, const PanelLayout& panel_layout) {
  const double width = panel_layout.right - panel_layout.left, height = panel_layout.bottom - panel_layout.top;
  const auto resize_range = [](const AxisRange& range, double span) {
    const double middle = (range.low + range.high) / 2;
    return AxisRange{middle - span / 2, middle + span / 2};
  };
  double per_mm = 1.12 * std::max((x.high - x.low) / width, (y.high - y.low) / height);
  if (!(per_mm > 0)) per_mm = 1e-3;  // nothing moves
  x = resize_range(x, per_mm * width);
  y = resize_range(y, per_mm * height);
}

/// The smallest of 1, 2 or 5 times a power of ten that separates tics by at least so many mm.
double tic_step(const AxisRange& range, double length, double min_spacing) {
  const double min_step = (range.high - range.low) * min_spacing / length;
  const double power = elementary::pow(10, std::floor(elementary::log10(min_step)));
  for (const double factor : {1.0, 2.0, 5.0})
    if (factor * power >= min_step * (1 - 1e-9)) return factor * power;
  return 10 * power;
}

std::string ranges(const Plot& picture, const PlotPanel& panel, const PanelLayout& panel_layout) {
  AxisRange x = range_over(panel, &PlotPoint::x), y;
  if (picture.equal_axes) {
    x = common_range(picture, &PlotPoint::x), y = common_range(picture, &PlotPoint::y);
    equalise_axes(x, y, panel_layout);
  } else {
    y = value_range(panel);
  }
  if (x.low == x.high) x.high = x.low + 1;
  const bool zero_line = !picture.equal_axes && y.low < 0 && y.high > 0;
  double x_step = tic_step(x, panel_layout.right - panel_layout.left, 15),
         y_step = tic_step(y, panel_layout.bottom - panel_layout.top, 7);
  if (picture.equal_axes) x_step = y_step = std::max(x_step, y_step);
  return fmt::format("set xrange [{:.9g}:{:.9g}]\nset yrange [{:.9g}:{:.9g}]\n", x.low, x.high, y.low, y.high) +
         fmt::format("set xtics {:g}\nset ytics {:g}\n", x_step, y_step) +
         (zero_line ? fmt::format("set xzeroaxis linetype 1 linewidth 0.6 linecolor rgb '{}'\n", grey)
                    : std::string("unset xzeroaxis\n"));
}

/// A text at a position in mm from the top left corner.
std::string label(int number, const std::string& text, double x, double y, const PageLayout& page,
                  const char* placement) {
  return fmt::format("set label {} {} at screen {:.6f},{:.6f} {}\n", number, gnuplot_quoted(text), x / page.width,
                     1 - y / page.height, placement);
}

/// Drawn explicitly: gnuplot estimates text widths, differently for every format.
std::string legend(const PlotPanel& panel, const PanelLayout& panel_layout, const PageLayout& page) {
  std::string text;
  auto entry = panel_layout.legend.begin();
  int number = first_legend_label;
  const auto at = [&](double x) {
    return fmt::format("screen {:.6f},{:.6f}", x / page.width, 1 - entry->y / page.height);
  };
  const auto name = [&](const std::string& words) {
    text += label(number++, words, entry->text, entry->y, page, "left");
    ++entry;
  };
  const auto line_entry = [&](const std::string& words, const LineStyle& pen) {
    if (words.empty() || entry == panel_layout.legend.end()) return;
    text += fmt::format("set arrow from {} to {} nohead {}\n", at(entry->sample), at(entry->sample_end), stroke(pen));
    name(words);
  };
  for (const PlotLine& line : panel.lines) line_entry(line.label, line.pen);
  for (const PlotShape& shape : panel.shapes) line_entry(shape.label, shape.pen);
  for (const PlotMarker& mark : panel.marks) {
    if (mark.label.empty() || entry == panel_layout.legend.end()) continue;
    text += fmt::format("set label {} '' at {} point {}\n", number++, at((entry->sample + entry->sample_end) / 2),
                        stroke(mark));
    name(mark.label);
  }
  return text;
}

std::string panel_text(const Plot& picture, std::size_t index, const PageLayout& layout, const Sizes& page_sizes) {
  const PlotPanel& panel = picture.panels[index];
  const PanelLayout& panel_layout = layout.panels[index];
  std::string text =
      margins(panel_layout, layout) + ranges(picture, panel, panel_layout) + legend(panel, panel_layout, layout);
  const double middle = (panel_layout.left + panel_layout.right) / 2;
  // instead of gnuplot's own labels, whose position differs from panel to panel
  if (panel_layout.has_y_label)
    text += label(2, panel.y_label, layout.y_label, (panel_layout.top + panel_layout.bottom) / 2, layout,
                  "rotate by 90 center");
  if (index == 0 && !picture.title.empty())
    text += label(1, picture.title, panel_layout.left, layout.title, layout, "left");
  if (panel_layout.has_x_label)
    text += label(3, picture.x_label, middle, panel_layout.bottom + page_sizes.x_label(), layout, "center");
  if (!panel.heading.empty()) text += label(4, panel.heading, middle, panel_layout.heading, layout, "center");
  text += panel_layout.has_x_label ? "set format x '%g'\n" : "set format x ''\n";
  if (picture.columns > 1) text += panel_layout.has_y_label ? "set format y '%g'\n" : "set format y ''\n";
  return text + plot_command(panel, index) + "unset label\nunset arrow\n";
}

}  // namespace

std::string gnuplot_quoted(std::string_view text) {
  const std::string escaped = escape_for_terminal(text);
  if (escaped.find('\'') == std::string::npos) return "'" + escaped + "'";
  // gnuplot 5.4 takes a doubled quote at either end of a text for its end. Double quotes avoid that; three other
  // characters are special in them.
  std::string quoted = "\"";
  for (const char c : escaped)
    quoted += c == '"' || c == '\\' || c == '`' ? fmt::format("\\{:03o}", static_cast<int>(c)) : std::string(1, c);
  return quoted + "\"";
}

PlotPage resolve_page_size(const Plot& picture, PlotPage page) {
  if (page.width <= 0) page.width = picture.columns > 1 ? 180 : 120;
  if (page.height <= 0) page.height = std::round(default_height(picture, page));
  check_page_size(picture, page);
  return page;
}

std::string gnuplot_script(const Plot& picture, const PlotPage& options) {
  const PlotPage page = resolve_page_size(picture, options);
  const PageLayout layout = compute_layout(picture, page);
  std::string text = "set encoding utf8\nset minussign\nset terminal " + terminal(page) + "\n";
  for (std::size_t i = 0; i < picture.panels.size(); ++i) text += data_blocks(picture.panels[i], i);
  text += fmt::format(
      "set border 3 linewidth 0.7 linecolor rgb '#30363d'\nset tics nomirror out scale 0.6\n"
      "set grid ytics {} linetype 1 linewidth 0.5 linecolor rgb '{}'\nset format y '%g'\n",
      picture.equal_axes ? "xtics" : "noxtics", pale);
  text += "unset key\nset multiplot\n";
  for (std::size_t i = 0; i < picture.panels.size(); ++i) text += panel_text(picture, i, layout, sizes_of(page));
  return text + "unset multiplot\n";
}

}  // namespace balance::reports
