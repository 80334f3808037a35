#pragma once
/// A YAML document as plain values, as parsed by yaml-cpp, with places counted from one. Aliases are
/// copies of what they repeat.

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
  std::size_t begin = 0;  ///< byte where it begins, including its anchor and tag; for a copy, where the alias begins
  int anchor = 0;         ///< number of its anchor; 0: none
  int alias = 0;          ///< number of the anchor that it is a copy of; 0: none
  std::string text;       ///< of a scalar
  std::vector<YamlNode> items;  ///< of a list; the values of a map
  std::vector<YamlNode> keys;   ///< of a map: scalars, as many as items
};

/// Size limits of a spec, which bound the cost of all later steps.
struct DocumentLimits {
  std::size_t max_bytes = std::size_t{4} << 20;
  int max_depth = 64;
  long max_nodes = 200'000;  ///< after aliases are expanded
};

/// Parses one document. Duplicate keys go to `problems`.
/// @throws ReadError if the text is not YAML, contains more than one document or exceeds a limit
YamlNode parse_yaml(const std::string& text, SpecErrorCollector& problems, const DocumentLimits& limits = {});

// Values as YAML.

/// The text in double quotes, on one line.
std::string quote_yaml(const std::string& text);

/// The text as a scalar that is valid anywhere in YAML: trimmed, and in quotes unless it is a
/// number or a simple expression.
std::string format_scalar(const std::string& text);

/// The node on one line, valid anywhere in YAML. Aliases are written out.
std::string format_flow(const YamlNode& node);

}  // namespace balance::specification
