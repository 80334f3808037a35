#pragma once
/// The files of a spec's parts, each read and parsed once. Private to spec.

#include "balance/spec/cursor.hpp"

#include <functional>
#include <map>
#include <string>

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
  /// @throws Problem if it cannot be read, SpecError if it is no YAML
  const YamlNode& load(const std::string& path, const SpecCursor& at);

 private:
  PartReader text_;
  SpecErrorCollector* problems_;
  std::map<std::string, YamlNode> documents_;
};

}  // namespace balance::specification
