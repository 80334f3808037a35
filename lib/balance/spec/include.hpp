#pragma once
/// Specs that are made of parts: what `include` says, put in its place.

#include "balance/spec/part_files.hpp"

#include <string>
#include <vector>

namespace balance::read {

/// A document that includes nothing any more. Its nodes' places are where things were written, in whatever file.
struct FlatDocument {
  std::string text;                ///< that says it all, as YAML
  Node root;                       ///< of that text
  std::vector<std::string> files;  ///< that the parts were read from, as messages call them
};

bool includes_parts(const Node& root);

/// @param file what messages call the document; the parts' files are looked for in its folder
/// @throws Problem, SpecError if something is wrong with the parts; what is wrong inside of them is left to the readers
FlatDocument flatten(const Node& root, const std::string& file, Problems& problems,
                     const PartText& text = read_part_text);

}  // namespace balance::read
