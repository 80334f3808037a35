#include "balance/import/element_reader.hpp"

#include "balance/base/nearest.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <tuple>

namespace balance::foreign {

void ForeignDiagnostics::add(SourceLocation place, std::string key, std::string message) {
  place.key = std::move(key);
  mistakes_.push_back({.place = std::move(place), .message = std::move(message)});
  if (mistakes_.size() >= SpecError::max_counted_diagnostics) throw_if_any();
}

void ForeignDiagnostics::throw_if_any() const {
  if (is_empty()) return;
  std::vector<Diagnostic> ordered = mistakes_;
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
    const auto [stop, error] = std::from_chars(text.data() + i, text.data() + end, value);
    // what is too small to be told from zero is zero
    const std::string_view word = text.substr(i, end - i);
    const bool tiny =
        error == std::errc::result_out_of_range && (word.find("e-") != word.npos || word.find("E-") != word.npos);
    if (tiny) value = 0;
    if ((error != std::errc() && !tiny) || stop != text.data() + end || !std::isfinite(value)) return std::nullopt;
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
  faults_->add(place_of(at, attribute), std::move(key), message);
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

}  // namespace balance::foreign
