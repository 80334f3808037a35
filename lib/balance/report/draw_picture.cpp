#include "balance/report/draw_picture.hpp"

#include "balance/base/plain_text.hpp"
#include "balance/report/gnuplot.hpp"

#include <fmt/format.h>

#include <cctype>

namespace balance {
namespace {

void replace_first(std::string& text, std::string_view old, const std::string& now) {
  const std::size_t at = text.find(old);
  if (at != std::string::npos) text.replace(at, old.size(), now);
}

void replace_all(std::string& text, const std::string& old, const std::string& now) {
  for (std::size_t at = text.find(old); at != std::string::npos; at = text.find(old, at + now.size()))
    text.replace(at, old.size(), now);
}

std::string escape_xml(std::string_view text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '<') {
      escaped += "&lt;";
    } else if (c == '&') {
      escaped += "&amp;";
    } else {
      escaped += c;
    }
  }
  return escaped;
}

/// What the picture is called where it has no title: its quantities.
std::string name_of(const Plot& picture) {
  if (!picture.title.empty()) return escape_for_terminal(picture.title);  // as it is drawn
  std::string name;
  for (const PlotPanel& panel : picture.panels) name += (name.empty() ? "" : ", ") + panel.name;
  return name;
}

}  // namespace

std::string normalise_svg(std::string svg, const std::string& name, const PlotPage& page) {
  const std::size_t width = svg.find(" width=\""), end = svg.find('\n', width);
  if (width != std::string::npos && end != std::string::npos && width < svg.find("viewBox"))
    svg.replace(width, end - width, fmt::format(" width=\"{:g}mm\" height=\"{:g}mm\"", page.width, page.height));
  replace_first(svg, "<title>Gnuplot</title>", "<title>" + escape_xml(name) + "</title>");
  const std::string generic = page.font.find("Mono") != std::string::npos                            ? "monospace"
                              : page.font.find("Serif") != std::string::npos || page.font == "Times" ? "serif"
                                                                                                     : "sans-serif";
  const std::string fallback = page.font == "Helvetica" ? "Helvetica, Arial, " : page.font + ", ";
  replace_all(svg, fmt::format("font-family=\"{}\"", page.font),
              fmt::format("font-family=\"{}{}\"", fallback, generic));
  return svg;
}

std::string remove_pdf_date(std::string pdf) {
  constexpr std::string_view mark = "/CreationDate (D:", epoch = "19700101000000";
  const std::size_t at = pdf.find(mark);
  if (at == std::string::npos) return pdf;
  // In place, letter by letter: the file holds a table of where its parts begin.
  for (std::size_t i = 0; i < epoch.size(); ++i) {
    char& digit = pdf[at + mark.size() + i];
    if (!std::isdigit(static_cast<unsigned char>(digit))) break;
    digit = epoch[i];
  }
  return pdf;
}

std::string render_plot(const Plot& picture, const PlotPage& options) {
  const PlotPage page = resolve_page_size(picture, options);
  std::string drawn = run_gnuplot(gnuplot_script(picture, page));
  if (page.format == PlotFileFormat::svg) return normalise_svg(std::move(drawn), name_of(picture), page);
  return page.format == PlotFileFormat::pdf ? remove_pdf_date(std::move(drawn)) : drawn;
}

}  // namespace balance
