#include "balance/import/xml_edits.hpp"

#include "balance/import/element_reader.hpp"
#include "balance/import/spec_page.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

namespace balance::foreign {

std::string numbers_text(const std::vector<double>& values) {
  std::string text;
  for (const double value : values) text += (text.empty() ? "" : " ") + format_yaml_number(value);
  return text;
}

void XmlEdits::set(const XmlElement& at, const char* attribute, const std::vector<double>& values) {
  const std::string* before = at.attribute(attribute);
  if (before != nullptr && parse_number_list(*before).value_or(std::vector<double>{}) == values) return;
  const XmlSpan span = value_span(at, attribute);
  const std::size_t behind_name = at.offset + at.name.size();
  if (span.end > span.begin)
    edits_.push_back({span.begin, span.end, numbers_text(values)});
  else if (values != std::vector<double>{0})
    edits_.push_back({behind_name, behind_name, fmt::format(" {}=\"{}\"", attribute, numbers_text(values))});
}

void XmlEdits::replace(const XmlElement& at, const char* attribute, const char* other,
                       const std::vector<double>& values) {
  const XmlSpan span = value_span(at, attribute);
  const std::string& text = at.document->text;
  const std::size_t begin = text.rfind(attribute, span.begin);
  edits_.push_back({begin, span.end, fmt::format("{}={}{}", other, text[span.begin - 1], numbers_text(values))});
}

void XmlEdits::remove(const XmlElement& at, const char* attribute) {
  const XmlSpan span = value_span(at, attribute);
  const std::string& text = at.document->text;
  std::size_t begin = text.rfind(attribute, span.begin);
  while (begin > 0 && std::string_view(" \t\r\n").find(text[begin - 1]) != std::string_view::npos) --begin;
  edits_.push_back({begin, span.end + 1, ""});
}

void XmlEdits::insert_before(const XmlElement& at, const std::string& text) {
  edits_.push_back({at.offset - 1, at.offset - 1, text});
}

void XmlEdits::insert_inside(const XmlElement& at, const std::string& text) {
  const std::string& all = at.document->text;
  char quote = 0;
  std::size_t end = at.offset;
  for (; end < all.size() && (quote != 0 || all[end] != '>'); ++end)
    if (quote != 0 ? all[end] == quote : all[end] == '"' || all[end] == '\'') quote = quote != 0 ? 0 : all[end];
  if (end > 0 && all[end - 1] == '/')  // an element without anything inside is opened
    edits_.push_back({end - 1, end + 1, fmt::format(">{}</{}>", text, at.name)});
  else
    edits_.push_back({end + 1, end + 1, text});
}

std::string XmlEdits::apply(const std::string& text) {
  std::stable_sort(edits_.begin(), edits_.end(), [](const Edit& a, const Edit& b) { return a.begin < b.begin; });
  std::string out;
  std::size_t at = 0;
  for (const Edit& edit : edits_) {
    out += text.substr(at, edit.begin - at) + edit.text;
    at = edit.end;
  }
  return out + text.substr(at);
}

}  // namespace balance::foreign
