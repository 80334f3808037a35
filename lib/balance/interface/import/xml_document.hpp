#pragma once
/// An XML document as plain values, with places counted from one. Entities are not expanded but for XML's own five and numbered
/// characters; what a document type says is not read; nothing is fetched.

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

/// What an element of some name says where it does not say it itself: attributes by name.
using XmlDefaults = std::unordered_map<std::string, std::string>;

struct XmlElement {
  std::string name;
  std::string text;  ///< directly inside
  std::vector<XmlAttribute> attributes;
  std::vector<XmlElement> children;
  const XmlDocument* document = nullptr;     ///< that it stands in
  std::size_t offset = 0;                    ///< byte of its name
  int line = 0;                              ///< from 1
  std::vector<const XmlDefaults*> defaults;  ///< the nearest first; owned by the maker of the element

  /// Null if there is none of that name.
  const XmlElement* child(std::string_view wanted) const;
  const std::string* attribute(std::string_view wanted) const;
  /// The same without the defaults.
  const std::string* own_attribute(std::string_view wanted) const;
};

/// Never copied: elements point into it.
struct XmlDocument {
  std::string file, text;
  XmlElement root;
  std::vector<std::size_t> line_starts = {};       ///< bytes at which lines begin
  std::vector<std::size_t> character_counts = {};  ///< before each block of bytes
};

/// Where an attribute stands; the element where it has none of that name.
SourceLocation place_of(const XmlElement& element, std::string_view attribute = {});

/// Bytes of an attribute's value in the document's text, without its quotes; empty if there is no such attribute.
struct XmlSpan {
  std::size_t begin = 0, end = 0;
};
XmlSpan value_span(const XmlElement& element, std::string_view attribute);

/// Limits that keep every later step small.
struct XmlLimits {
  std::size_t bytes = std::size_t{4} << 20;
  int depth = 200;
  long elements = 100'000;
};

/// @throws SpecError if the text is no XML of one root element or exceeds a limit
std::unique_ptr<const XmlDocument> parse_xml(std::string text, std::string file, const XmlLimits& limits = {});

// Numbers and names in XML attributes; what is wrong with them is collected with its place.

/// Everything that is wrong with a foreign file, in the order in which it was met.
class ForeignDiagnostics {
 public:
  void add(SourceLocation place, std::string key, std::string message);
  bool is_empty() const { return mistakes_.empty(); }
  /// @throws SpecError if there is any
  void throw_if_any() const;

 private:
  std::vector<Diagnostic> mistakes_;
};

/// Whether an element's or attribute's name is known.
inline bool is_one_of(std::string_view name, std::initializer_list<std::string_view> known) {
  return std::find(known.begin(), known.end(), name) != known.end();
}

/// Numbers between blanks, in any locale written with a point. Nothing if the text is anything else or one is not finite.
std::optional<std::vector<double>> parse_number_list(std::string_view text);

class XmlAttributeReader {
 public:
  explicit XmlAttributeReader(ForeignDiagnostics& faults) : faults_(&faults) {}

  /// A mistake in an element or in one of its attributes.
  void report(const XmlElement& at, std::string_view attribute, const std::string& message) const;
  /// `fallback` if there is no such attribute, or a mistake.
  double number(const XmlElement& at, std::string_view attribute, double fallback) const;
  Vector3 vector(const XmlElement& at, std::string_view attribute, const Vector3& fallback) const;
  /// As many numbers as one of the counts says; empty if there is no such attribute, or a mistake.
  std::vector<double> numbers(const XmlElement& at, std::string_view attribute,
                              std::initializer_list<std::size_t> counts) const;
  /// The attribute's text, a mistake if there is none; then empty.
  std::string required_text(const XmlElement& at, std::string_view attribute) const;

 private:
  ForeignDiagnostics* faults_;
};

}  // namespace balance::foreign
