// The only file that depends on pugixml.

#include "balance/interface/import/xml_document.hpp"

#include "balance/foundation/base/spelling.hpp"
#include "balance/foundation/base/unicode_text.hpp"

#include <fmt/format.h>
#include <pugixml.hpp>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <tuple>

namespace balance::foreign {

void ForeignDiagnostics::add(SourceLocation place, std::string key, std::string message) {
  place.key = std::move(key);
  diagnostics_.push_back({.place = std::move(place), .message = std::move(message)});
  if (diagnostics_.size() >= SpecError::max_counted_diagnostics) throw_if_any();
}

void ForeignDiagnostics::throw_if_any() const {
  if (is_empty()) return;
  std::vector<Diagnostic> ordered = diagnostics_;
  std::stable_sort(ordered.begin(), ordered.end(), [](const Diagnostic& a, const Diagnostic& b) {
    return std::tie(a.place.file, a.place.line, a.place.column) < std::tie(b.place.file, b.place.line, b.place.column);
  });
  throw SpecError(std::move(ordered));
}

std::optional<std::vector<double>> parse_number_list(std::string_view text) {
  std::vector<double> values;
  for (std::size_t i = text.find_first_not_of(" \t\r\n"); i != std::string_view::npos;
       i = text.find_first_not_of(" \t\r\n", i)) {
    std::size_t end = std::min(text.find_first_of(" \t\r\n", i), text.size());
    if (text[i] == '+' && i + 1 < end && text[i + 1] != '-') ++i;
    double value = 0;
    const auto [parsed_end, error] = std::from_chars(text.data() + i, text.data() + end, value);
    // numbers that underflow are zero
    const std::string_view word = text.substr(i, end - i);
    const bool is_underflow =
        error == std::errc::result_out_of_range && (word.find("e-") != word.npos || word.find("E-") != word.npos);
    if (is_underflow) value = 0;
    if ((error != std::errc() && !is_underflow) || parsed_end != text.data() + end || !std::isfinite(value))
      return std::nullopt;
    values.push_back(value);
    i = end;
  }
  return values;
}

void XmlAttributeReader::report(const XmlElement& at, std::string_view attribute, const std::string& message) const {
  std::string key = at.name;
  if (const std::string* name = at.attribute("name"); name != nullptr && !name->empty())
    key += " " + quote_for_message(*name);
  if (!attribute.empty()) key += "." + std::string(attribute);
  diagnostics_->add(place_of(at, attribute), std::move(key), message);
}

std::vector<double> XmlAttributeReader::numbers(const XmlElement& at, std::string_view attribute,
                                                std::initializer_list<std::size_t> counts) const {
  const std::string* text = at.attribute(attribute);
  if (text == nullptr) return {};
  const auto values = parse_number_list(*text);
  if (values && std::find(counts.begin(), counts.end(), values->size()) != counts.end()) return *values;
  std::vector<std::string> expected;
  for (const std::size_t count : counts) expected.push_back(std::to_string(count));
  report(at, attribute,
         fmt::format("expected {} number{}, found {}", join_alternatives(expected),
                     counts.size() == 1 && *counts.begin() == 1 ? "" : "s", quote_for_message(*text)));
  return {};
}

double XmlAttributeReader::number(const XmlElement& at, std::string_view attribute, double fallback) const {
  const auto values = numbers(at, attribute, {1});
  return values.empty() ? fallback : values.front();
}

Vector3 XmlAttributeReader::vector(const XmlElement& at, std::string_view attribute, const Vector3& fallback) const {
  const auto values = numbers(at, attribute, {3});
  return values.empty() ? fallback : Vector3(values[0], values[1], values[2]);
}

std::string XmlAttributeReader::required_text(const XmlElement& at, std::string_view attribute) const {
  const std::string* text = at.attribute(attribute);
  if (text != nullptr && !text->empty()) return *text;
  report(at, attribute, fmt::format("expected {}=\"…\"", attribute));
  return "";
}

namespace {

constexpr std::size_t index_block_bytes = 1024;

bool is_character_start(char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; }

/// Indexes the text once: a file has thousands of locations to report, in lines of any length.
void index_locations(XmlDocument& document) {
  document.line_starts = {0};
  std::size_t count = 0;
  for (std::size_t i = 0; i < document.text.size(); ++i) {
    if (i % index_block_bytes == 0) document.character_counts.push_back(count);
    if (document.text[i] == '\n') document.line_starts.push_back(i + 1);
    if (is_character_start(document.text[i])) ++count;
  }
}

/// Number of characters before a byte offset.
std::size_t count_characters_before(const XmlDocument& document, std::size_t offset) {
  if (document.character_counts.empty()) return 0;
  const std::size_t begin =
      std::min(offset / index_block_bytes, document.character_counts.size() - 1) * index_block_bytes;
  const char* const text = document.text.data();
  return document.character_counts[begin / index_block_bytes] +
         static_cast<std::size_t>(std::count_if(text + begin, text + offset, is_character_start));
}

/// Line and column, both from one; columns in characters.
SourceLocation place_at(const XmlDocument& document, std::size_t offset) {
  offset = std::min(offset, document.text.size());
  const auto next = std::upper_bound(document.line_starts.begin(), document.line_starts.end(), offset);
  const auto line = next - document.line_starts.begin();
  const std::size_t column =
      1 + count_characters_before(document, offset) - count_characters_before(document, *(next - 1));
  return {document.file, static_cast<int>(line), static_cast<int>(column), ""};
}

[[noreturn]] void fail(const SourceLocation& place, const std::string& message) {
  throw SpecError({.place = place, .message = message});
}

std::string describe_status(pugi::xml_parse_status status) {
  switch (status) {
    case pugi::status_end_element_mismatch: return "an element without a matching end tag";
    case pugi::status_bad_attribute: return "an attribute that is not name=\"value\"";
    case pugi::status_bad_comment: return "a comment that is not closed";
    case pugi::status_bad_doctype: return "a document type that is not closed";
    case pugi::status_no_document_element: return "no element at all";
    default: return "a syntax error";
  }
}

/// Builds the plain tree up to the depth limit. Counts lines as the nodes arrive, in the order of the text.
class XmlTreeBuilder {
 public:
  XmlTreeBuilder(const XmlDocument& document, const XmlLimits& limits) : document_(document), limits_(limits) {}

  XmlElement build(const pugi::xml_node& root) {
    XmlElement root_element;
    fill(root, root_element, 1);
    return root_element;
  }

 private:
  void fill(const pugi::xml_node& node, XmlElement& element, int depth) {
    const auto offset = static_cast<std::size_t>(std::max<std::ptrdiff_t>(node.offset_debug(), 0));
    line_ += std::count(document_.text.begin() + static_cast<std::ptrdiff_t>(counted_offset_),
                        document_.text.begin() + static_cast<std::ptrdiff_t>(offset), '\n');
    counted_offset_ = offset;
    element.name = node.name();
    element.text = node.text().get();
    element.document = &document_;
    element.offset = offset;
    element.line = static_cast<int>(line_);
    for (const pugi::xml_attribute& one : node.attributes()) element.attributes.push_back({one.name(), one.value()});
    if (depth > limits_.depth)
      fail(place_of(element), fmt::format("expected at most {} levels of nesting", limits_.depth));
    if (++elements_ > limits_.elements)
      fail(place_of(element), fmt::format("expected at most {} elements", limits_.elements));
    for (const pugi::xml_node& child : node.children())
      if (child.type() == pugi::node_element) fill(child, element.children.emplace_back(), depth + 1);
  }

  const XmlDocument& document_;
  const XmlLimits& limits_;
  std::size_t counted_offset_ = 0;
  std::ptrdiff_t line_ = 1;
  long elements_ = 0;
};

void check_bytes(const XmlDocument& document, const XmlLimits& limits) {
  const std::string& text = document.text;
  if (text.size() > limits.bytes)
    fail({document.file, 1, 1, ""}, fmt::format("expected at most {} MiB, found more", limits.bytes >> 20));
  if (text.find_first_not_of(" \t\r\n") == std::string::npos)
    fail({document.file, 1, 1, ""}, "expected XML, found an empty file");
  if (!is_utf8(text) || text.find('\0') != std::string::npos) {
    std::size_t invalid_offset = 0;
    while (invalid_offset < text.size() && text[invalid_offset] != '\0') {
      const std::size_t bytes = decode_utf8(std::string_view(text).substr(invalid_offset)).bytes;
      if (bytes == 0) break;
      invalid_offset += bytes;
    }
    fail(place_at(document, invalid_offset), "expected text (UTF-8), found a binary file or another encoding");
  }
}

}  // namespace

const XmlElement* XmlElement::child(std::string_view child_name) const {
  const auto match =
      std::find_if(children.begin(), children.end(), [&](const XmlElement& one) { return one.name == child_name; });
  return match == children.end() ? nullptr : &*match;
}

const std::string* XmlElement::attribute(std::string_view attribute_name) const {
  if (const std::string* value = own_attribute(attribute_name)) return value;
  for (const XmlDefaults* one : defaults)
    if (const auto match = one->find(std::string(attribute_name)); match != one->end()) return &match->second;
  return nullptr;
}

const std::string* XmlElement::own_attribute(std::string_view attribute_name) const {
  const auto match = std::find_if(attributes.begin(), attributes.end(),
                                  [&](const XmlAttribute& one) { return one.name == attribute_name; });
  return match == attributes.end() ? nullptr : &match->value;
}

namespace {

/// Byte offset of an attribute's name in its element's tag; npos if there is no such attribute.
std::size_t find_attribute(const XmlElement& element, std::string_view attribute) {
  const std::string& text = element.document->text;
  char quote = 0;
  for (std::size_t i = element.offset; i < text.size() && (quote != 0 || text[i] != '>'); ++i) {
    if (quote != 0) {
      if (text[i] == quote) quote = 0;
    } else if (text[i] == '"' || text[i] == '\'') {
      quote = text[i];
    } else if (i > element.offset && std::isspace(static_cast<unsigned char>(text[i - 1])) != 0 &&
               text.compare(i, attribute.size(), attribute) == 0) {
      const std::size_t next = text.find_first_not_of(" \t\r\n", i + attribute.size());
      if (next != std::string::npos && text[next] == '=') return i;
    }
  }
  return std::string::npos;
}

}  // namespace

SourceLocation place_of(const XmlElement& element, std::string_view attribute) {
  const std::size_t at = attribute.empty() ? std::string::npos : find_attribute(element, attribute);
  return place_at(*element.document, at == std::string::npos ? element.offset : at);
}

XmlSpan value_span(const XmlElement& element, std::string_view attribute) {
  const std::string& text = element.document->text;
  const std::size_t name = find_attribute(element, attribute);
  if (name == std::string::npos) return {};
  const std::size_t open = text.find_first_of("\"'", name);
  if (open == std::string::npos) return {};
  return {open + 1, std::min(text.find(text[open], open + 1), text.size())};
}

std::unique_ptr<const XmlDocument> parse_xml(std::string text, std::string file, const XmlLimits& limits) {
  auto document = std::make_unique<XmlDocument>();
  document->file = std::move(file);
  document->text = std::move(text);
  index_locations(*document);
  check_bytes(*document, limits);

  pugi::xml_document parsed;
  const pugi::xml_parse_result result =
      parsed.load_buffer(document->text.data(), document->text.size(), pugi::parse_default, pugi::encoding_utf8);
  if (!result)
    fail(place_at(*document, static_cast<std::size_t>(std::max<std::ptrdiff_t>(result.offset, 0))),
         "expected XML, found " + describe_status(result.status));
  const pugi::xml_node root = parsed.document_element();
  for (pugi::xml_node sibling = root.next_sibling(); sibling; sibling = sibling.next_sibling())
    if (sibling.type() == pugi::node_element)
      fail(place_at(*document, static_cast<std::size_t>(sibling.offset_debug())),
           "expected one root element, found a second one");
  document->root = XmlTreeBuilder(*document, limits).build(root);
  return document;
}

}  // namespace balance::foreign
