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
class Faults {
 public:
  void add(SpecPlace place, std::string key, std::string message);
  bool none() const { return mistakes_.empty(); }
  /// @throws SpecError if there is any
  void throw_all() const;

 private:
  std::vector<Mistake> mistakes_;
};

/// Numbers between blanks, in any locale written with a point. Nothing if the text is anything else or one is not finite.
std::optional<std::vector<double>> numbers_in(std::string_view text);

class ElementReader {
 public:
  explicit ElementReader(Faults& faults) : faults_(&faults) {}

  /// A mistake in an element or in one of its attributes.
  void fault(const XmlElement& at, std::string_view attribute, const std::string& message) const;
  /// `fallback` if there is no such attribute, or a mistake.
  double number(const XmlElement& at, std::string_view attribute, double fallback) const;
  Vector3 vector(const XmlElement& at, std::string_view attribute, const Vector3& fallback) const;
  /// As many numbers as one of the counts says; empty if there is no such attribute, or a mistake.
  std::vector<double> numbers(const XmlElement& at, std::string_view attribute,
                              std::initializer_list<std::size_t> counts) const;
  /// The attribute's text, a mistake if there is none; then empty.
  std::string word(const XmlElement& at, std::string_view attribute) const;

 private:
  Faults* faults_;
};

}  // namespace balance::foreign
