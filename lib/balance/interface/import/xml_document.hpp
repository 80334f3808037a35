#pragma once
/// XML document as plain values, with locations counted from one. Expands only XML's five predefined entities and
/// character references. Ignores the document type; fetches nothing.

#include "balance/foundation/base/error.hpp"
#include "balance/foundation/base/types.hpp"

#include <algorithm>
#include <cstddef>
#include <initializer_list>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

namespace balance::foreign {

struct XmlAttribute {
  std::string name, value;
};

struct XmlDocument;

/// Default attribute values of an element, by attribute name.
using XmlDefaults = std::unordered_map<std::string, std::string>;

struct XmlElement {
  std::string name;
  std::string text;  ///< directly inside
  std::vector<XmlAttribute> attributes;
  std::vector<XmlElement> children;
  const XmlDocument* document = nullptr;     ///< that contains it
  std::size_t offset = 0;                    ///< byte offset of its name
  int line = 0;                              ///< from 1
  std::vector<const XmlDefaults*> defaults;  ///< nearest first; owned by the creator of the element

  /// Returns nullptr if there is none of that name.
  const XmlElement* child(std::string_view child_name) const;
  const std::string* attribute(std::string_view child_name) const;
  /// The same without the defaults.
  const std::string* own_attribute(std::string_view child_name) const;
};

/// Must not be copied: elements point to it.
struct XmlDocument {
  std::string file, text;
  XmlElement root;
  std::vector<std::size_t> line_starts = {};       ///< byte offsets at which lines begin
  std::vector<std::size_t> character_counts = {};  ///< number of characters before each block of bytes
};

/// Location of an attribute, or of the element if it has no such attribute.
SourceLocation place_of(const XmlElement& element, std::string_view attribute = {});

/// Byte range of an attribute's value in the document's text, without its quotes; empty if there is no such attribute.
struct XmlSpan {
  std::size_t begin = 0, end = 0;
};
XmlSpan value_span(const XmlElement& element, std::string_view attribute);

/// Limits that bound the cost of all later steps.
struct XmlLimits {
  std::size_t bytes = std::size_t{4} << 20;
  int depth = 200;
  long elements = 100'000;
};

/// @throws SpecError if the text is not well-formed XML with a single root element, or exceeds a limit
std::unique_ptr<const XmlDocument> parse_xml(std::string text, std::string file, const XmlLimits& limits = {});

// Numbers and names in XML attributes. Mistakes are collected with their location.

/// Collects the mistakes in a foreign file.
class ForeignDiagnostics {
 public:
  void add(SourceLocation place, std::string key, std::string message);
  bool is_empty() const { return diagnostics_.empty(); }
  /// @throws SpecError listing all mistakes by location, if there are any
  void throw_if_any() const;

 private:
  std::vector<Diagnostic> diagnostics_;
};

/// Whether an element's or attribute's name is known.
inline bool is_one_of(std::string_view name, std::initializer_list<std::string_view> known) {
  return std::find(known.begin(), known.end(), name) != known.end();
}

/// Parses numbers separated by blanks, with a decimal point in any locale. Returns std::nullopt if the text is anything
/// else or a number is not finite.
std::optional<std::vector<double>> parse_number_list(std::string_view text);

class XmlAttributeReader {
 public:
  explicit XmlAttributeReader(ForeignDiagnostics& diagnostics) : diagnostics_(&diagnostics) {}

  /// Reports a mistake in an element or in one of its attributes.
  void report(const XmlElement& at, std::string_view attribute, const std::string& message) const;
  /// Returns `fallback` if the attribute is missing or wrong.
  double number(const XmlElement& at, std::string_view attribute, double fallback) const;
  Vector3 vector(const XmlElement& at, std::string_view attribute, const Vector3& fallback) const;
  /// Accepts as many numbers as one of `counts`. Empty if the attribute is missing or wrong.
  std::vector<double> numbers(const XmlElement& at, std::string_view attribute,
                              std::initializer_list<std::size_t> counts) const;
  /// The attribute's text. Reports a mistake and returns an empty string if it is missing or empty.
  std::string required_text(const XmlElement& at, std::string_view attribute) const;

 private:
  ForeignDiagnostics* diagnostics_;
};

}  // namespace balance::foreign
