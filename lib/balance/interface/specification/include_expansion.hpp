#pragma once
/// Parts of a spec: their files, each read and parsed once, and their insertion.

#include "balance/interface/specification/spec_cursor.hpp"

#include <functional>
#include <map>
#include <string>
#include <vector>

namespace balance::specification {

/// Returns a file's text. @throws SystemError with the reason if it cannot be read
using PartReader = std::function<std::string(const std::string& path)>;

/// From a regular file: pipes and devices may be endless. @throws SystemError
std::string read_part_text(const std::string& path);

class PartFiles {
 public:
  PartFiles(PartReader text, SpecErrorCollector& problems) : text_(std::move(text)), problems_(&problems) {}

  /// A part's document, with all places in its file. Valid as long as this object.
  /// @param path also its name in messages @param at where the spec names it
  /// @throws ReadError if it cannot be read, SpecError if it is not YAML
  const YamlNode& load(const std::string& path, const SpecCursor& at);

 private:
  PartReader text_;
  SpecErrorCollector* problems_;
  std::map<std::string, YamlNode> documents_;
};

// Specs that consist of parts: expansion of `include`.

/// A document without includes. Places of its nodes are where they were written, in any file.
struct ExpandedDocument {
  std::string text;                ///< of the complete document, as YAML
  YamlNode root;                   ///< of that text
  std::vector<std::string> files;  ///< files of the parts, as named in messages
};

bool has_includes(const YamlNode& root);

/// @param file name of the document in messages; the parts' files are looked for in its folder
/// @throws ReadError, SpecError if the parts cannot be inserted; mistakes inside them are left to the readers
ExpandedDocument expand_includes(const YamlNode& root, const std::string& file, SpecErrorCollector& problems,
                                 const PartReader& text = read_part_text);

// The files that a spec consists of.

/// Tables, parts, and the tables and parts of parts, with their folders; each once. A file that
/// cannot be read references none.
/// @param spec_file name of the spec in messages; its files are looked for in its folder
std::vector<std::string> list_referenced_files(const std::string& spec_text, const std::string& spec_file);

/// The spec itself, if it is a file, and the result of list_referenced_files(). A text with its parts already inserted
/// no longer names them, so the file is read again.
std::vector<std::string> list_spec_files(const std::string& spec_text, const std::string& spec_file);

}  // namespace balance::specification
