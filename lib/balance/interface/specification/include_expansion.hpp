#pragma once
/// The files of a spec's parts, each read and parsed once.

#include "balance/interface/specification/spec_cursor.hpp"

#include <functional>
#include <map>
#include <string>
#include <vector>

namespace balance::specification {

/// A file's text. @throws SystemError with the reason if it cannot be had
using PartReader = std::function<std::string(const std::string& path)>;

/// From a regular file: pipes and devices have no end. @throws SystemError
std::string read_part_text(const std::string& path);

class PartFiles {
 public:
  PartFiles(PartReader text, SpecErrorCollector& problems) : text_(std::move(text)), problems_(&problems) {}

  /// A part's document, every place of it in its file. Valid as long as this.
  /// @param path as messages call it @param at where the spec names it
  /// @throws ReadError if it cannot be read, SpecError if it is no YAML
  const YamlNode& load(const std::string& path, const SpecCursor& at);

 private:
  PartReader text_;
  SpecErrorCollector* problems_;
  std::map<std::string, YamlNode> documents_;
};

// Specs that are made of parts: what `include` says, put in its place.

/// A document that includes nothing any more. Its nodes' places are where things were written, in whatever file.
struct ExpandedDocument {
  std::string text;                ///< that says it all, as YAML
  YamlNode root;                   ///< of that text
  std::vector<std::string> files;  ///< that the parts were read from, as messages call them
};

bool has_includes(const YamlNode& root);

/// @param file what messages call the document; the parts' files are looked for in its folder
/// @throws ReadError, SpecError if something is wrong with the parts; what is wrong inside of them is left to the readers
ExpandedDocument expand_includes(const YamlNode& root, const std::string& file, SpecErrorCollector& problems,
                                 const PartReader& text = read_part_text);

}  // namespace balance::specification

namespace balance {

// The files that a spec is read with.

/// Tables, parts, and the tables and parts of parts, with their folders; each once. What cannot be read names nothing.
/// @param spec_file what messages call the spec: its files are looked for in its folder
std::vector<std::string> list_referenced_files(const std::string& spec_text, const std::string& spec_file);

/// The spec itself, where it is a file, and what list_referenced_files says of it. A text that has its parts in it already does not name
/// them, so the file is looked at again.
std::vector<std::string> list_spec_files(const std::string& spec_text, const std::string& spec_file);

}  // namespace balance
