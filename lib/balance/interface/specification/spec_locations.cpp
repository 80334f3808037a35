#include "balance/interface/specification/spec_locations.hpp"

#include "balance/interface/specification/include_expansion.hpp"
#include "balance/interface/specification/text_file.hpp"
#include "balance/interface/specification/yaml_document.hpp"

#include <filesystem>
#include <system_error>

namespace balance::specification {

namespace {

/// The text as the user wrote it: that of the study has its parts inserted.
std::string written_text(const Study& study) {
  std::error_code ignored;
  return std::filesystem::is_regular_file(study.spec_file, ignored) ? read_text_file(study.spec_file, "spec")
                                                                    : study.spec_text;
}

/// The key of the deepest entry along a path; null if the document has not even its first part.
const YamlNode* find_deepest_key(const YamlNode& root, const std::string& path) {
  const YamlNode *node = &root, *deepest = nullptr;
  for (std::size_t begin = 0; begin < path.size() && node->kind == YamlNode::Kind::map;) {
    const std::string rest = path.substr(begin);
    const YamlNode* next = nullptr;
    std::size_t length = 0;  // names may contain dots: the longest one that fits
    for (std::size_t k = 0; k < node->keys.size(); ++k) {
      const std::string& name = node->keys[k].text;
      const bool is_whole = rest.starts_with(name) && (rest.size() == name.size() || rest[name.size()] == '.');
      if (!is_whole || name.size() < length) continue;
      next = &node->items[k], deepest = &node->keys[k], length = name.size();
    }
    if (next == nullptr) break;
    node = next;
    begin += length + 1;
  }
  return deepest;
}

}  // namespace

SourceLocation locate_key(const Study& study, const std::string& key) {
  SourceLocation location{.file = study.spec_file, .key = key};
  SpecErrorCollector problems(study.spec_file);
  try {
    YamlNode root = parse_yaml(written_text(study), problems);
    ExpandedDocument flat;
    if (has_includes(root)) {
      flat = expand_includes(root, study.spec_file, problems);
      root = std::move(flat.root);
    }
    if (const YamlNode* found = find_deepest_key(root, key)) {
      location.file = problems.file_of(found->place);
      location.line = found->place.line, location.column = found->place.column;
    }
  } catch (const ReadError&) {  // the spec has changed since it was read
  } catch (const SpecError&) {
  } catch (const SystemError&) {
  }
  return location;
}

SourceLocation locate_trajectory(const Study& study, const Trajectory& trajectory) {
  const std::string path = "trajectories." + trajectory.name;
  const SourceLocation whole = locate_key(study, path);
  for (const char* key : {".free", ".from", ".speed"}) {
    const SourceLocation part = locate_key(study, path + key);
    if (part.line != whole.line || part.column != whole.column) return part;
  }
  return whole;
}

}  // namespace balance::specification
