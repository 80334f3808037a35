#pragma once
/// Numbers and names in XML attributes; what is wrong with them is collected with its place.

#include "balance/base/types.hpp"
#include "balance/import/xml_document.hpp"

#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace balance::foreign {

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
