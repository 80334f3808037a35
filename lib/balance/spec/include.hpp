#pragma once
/// Specs that are made of parts: what `include` says, put in its place.

#include "balance/spec/part_files.hpp"

#include <string>
#include <vector>

namespace balance::specification {

/// A document that includes nothing any more. Its nodes' places are where things were written, in whatever file.
struct ExpandedDocument {
  std::string text;                ///< that says it all, as YAML
  YamlNode root;                   ///< of that text
  std::vector<std::string> files;  ///< that the parts were read from, as messages call them
};

bool has_includes(const YamlNode& root);

/// @param file what messages call the document; the parts' files are looked for in its folder
/// @throws Problem, SpecError if something is wrong with the parts; what is wrong inside of them is left to the readers
ExpandedDocument expand_includes(const YamlNode& root, const std::string& file, SpecErrorCollector& problems,
                                 const PartReader& text = read_part_text);

}  // namespace balance::specification
