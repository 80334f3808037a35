#pragma once
/// A YAML document as plain values: what yaml-cpp saw, with places counted from one. Aliases are copies of what they repeat.

#include "balance/spec/problem.hpp"

#include <string>
#include <vector>

namespace balance::read {

struct Node {
  enum class Kind { null, scalar, list, map };

  Kind kind = Kind::null;
  bool quoted = false;  ///< a scalar in quotes
  bool flow = false;    ///< a list in brackets, a mapping in braces
  Place place;
  std::size_t begin =
      0;             ///< byte of the text where it begins, its anchor and tag included; a copy: where the alias does
  int anchor = 0;    ///< number of the anchor that it bears; 0: none
  int alias = 0;     ///< number of the anchor that it is a copy of; 0: none
  std::string text;  ///< of a scalar
  std::vector<Node> items;  ///< of a list; the values of a map
  std::vector<Node> keys;   ///< of a map: scalars, as many as items
};

/// Size limits of a spec; they keep every later step small.
struct DocumentLimits {
  std::size_t bytes = std::size_t{4} << 20;
  int depth = 64;
  long nodes = 200'000;  ///< after aliases are expanded
};

/// One document. Duplicate keys go to `problems`.
/// @throws Problem if the text is not YAML, holds more than one document or exceeds a limit
Node parse_yaml(const std::string& text, Problems& problems, const DocumentLimits& limits = {});

}  // namespace balance::read
