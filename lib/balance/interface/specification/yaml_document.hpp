#pragma once
/// A YAML document as plain values: what yaml-cpp saw, with places counted from one. Aliases are copies of what they repeat.

#include "balance/interface/specification/diagnostics.hpp"

#include <string>
#include <vector>

namespace balance::specification {

struct YamlNode {
  enum class Kind { null, scalar, list, map };

  Kind kind = Kind::null;
  bool is_quoted = false;  ///< a scalar in quotes
  bool is_flow = false;    ///< a list in brackets, a mapping in braces
  NodeLocation place;
  std::size_t begin =
      0;             ///< byte of the text where it begins, its anchor and tag included; a copy: where the alias does
  int anchor = 0;    ///< number of the anchor that it bears; 0: none
  int alias = 0;     ///< number of the anchor that it is a copy of; 0: none
  std::string text;  ///< of a scalar
  std::vector<YamlNode> items;  ///< of a list; the values of a map
  std::vector<YamlNode> keys;   ///< of a map: scalars, as many as items
};

/// Size limits of a spec; they keep every later step small.
struct DocumentLimits {
  std::size_t max_bytes = std::size_t{4} << 20;
  int max_depth = 64;
  long max_nodes = 200'000;  ///< after aliases are expanded
};

/// One document. Duplicate keys go to `problems`.
/// @throws ReadError if the text is not YAML, holds more than one document or exceeds a limit
YamlNode parse_yaml(const std::string& text, SpecErrorCollector& problems, const DocumentLimits& limits = {});

// Values as YAML.

/// The text in double quotes, on one line.
std::string quote_yaml(const std::string& text);

/// The text as a scalar that stands anywhere in YAML: without blanks around it, and in quotes unless it is a number or a simple
/// expression.
std::string format_scalar(const std::string& text);

/// The node on one line, anywhere in YAML. Aliases are written out.
std::string format_flow(const YamlNode& node);

}  // namespace balance::specification
