#include "balance/interface/specification/include_expansion.hpp"

#include "balance/foundation/base/error.hpp"
#include "balance/foundation/base/spelling.hpp"
#include "balance/foundation/base/unicode_text.hpp"
#include "balance/interface/specification/part_insertion.hpp"
#include "balance/interface/specification/spec_units.hpp"
#include "balance/interface/specification/text_file.hpp"
#include "balance/interface/specification/yaml_document.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <optional>
#include <stdexcept>

namespace balance::specification {

namespace {

/// Parts of parts of parts.
constexpr std::size_t max_include_depth = 8;

/// Sections that are imported from a part.
constexpr const char* imported_sections[]{"parameters",  "ground",    "bodies",   "joints",         "couplings",
                                          "constraints", "actuators", "assembly", "counterweights", "payloads",
                                          "discs",       "loads",     "springs",  "dampers",        "friction"};
/// Sections of a part that are ignored, so that it can be run by itself.
constexpr const char* ignored_sections[]{
    "name",        "space",  "gravity", "units",   "tool",      "trajectories",        "speeds",
    "controllers", "motion", "design",  "include", "workspace", "torque_distribution", "current_gains",
    "materials"};

long count_nodes(const YamlNode& node) {
  long count = 1 + static_cast<long>(node.keys.size());
  for (const YamlNode& item : node.items) count += count_nodes(item);
  return count;
}

void erase_entry(YamlNode& map, const std::string& key) {
  for (std::size_t i = 0; i < map.items.size(); ++i)
    if (map.keys[i].text == key) {
      map.keys.erase(map.keys.begin() + static_cast<std::ptrdiff_t>(i));
      map.items.erase(map.items.begin() + static_cast<std::ptrdiff_t>(i));
      return;
    }
}

/// Moves the first entries of a section, the document's own, behind those of its parts.
void move_to_end(YamlNode& section, std::size_t own_count) {
  const auto middle = static_cast<std::ptrdiff_t>(own_count);
  std::rotate(section.items.begin(), section.items.begin() + middle, section.items.end());
  if (!section.keys.empty()) std::rotate(section.keys.begin(), section.keys.begin() + middle, section.keys.end());
}

bool is_same_units(const Units& a, const Units& b) {
  return a.length == b.length && a.mass == b.mass && a.time == b.time && a.angle == b.angle &&
         a.factor(dimension::force) == b.factor(dimension::force);
}

class IncludeExpansion {
 public:
  IncludeExpansion(SpecErrorCollector& problems, const PartReader& text)
      : problems_(problems), files_(text, problems) {}

  /// The document with its parts inserted.
  YamlNode expand(YamlNode document, const std::string& path) {
    const YamlNode* include_entry = find_entry(document, "include");
    if (include_entry == nullptr) return document;
    const YamlNode section = *include_entry;
    erase_entry(document, "include");
    const SpecCursor at(section, "include", problems_);
    chain_.push_back(path);
    // by index, as an invalid document may have a section twice; sections of parts are appended
    std::vector<std::size_t> own_counts;
    for (const YamlNode& entry : document.items) own_counts.push_back(entry.items.size());
    std::vector<std::string> names;
    const auto items = at.is_map() ? std::vector{at} : at.items("a part {file, as} or a list of them");
    for (const SpecCursor& item : items) problems_.collect([&] { insert_item(item, path, names, document); });
    chain_.pop_back();
    for (std::size_t i = 0; i < own_counts.size(); ++i) move_to_end(document.items[i], own_counts[i]);
    return document;
  }

  std::vector<std::string> files() const {
    std::vector<std::string> names;
    for (const auto& [path, part] : parts_) names.push_back(path);
    return names;
  }

 private:
  void insert_item(const SpecCursor& item, const std::string& path, std::vector<std::string>& names,
                   YamlNode& document) {
    IncludeEntry entry;
    const auto store_in = [](std::optional<SpecCursor>& slot) { return [&slot](const SpecCursor& c) { slot = c; }; };
    if (!read_fields(item, "a part {file, as, on, at, angle, set, without}",
                     {{"file", Presence::required, store_in(entry.file)},
                      {"as", Presence::required, store_in(entry.as)},
                      {"on", Presence::optional, store_in(entry.on)},
                      {"at", Presence::optional, store_in(entry.at)},
                      {"angle", Presence::optional, store_in(entry.angle)},
                      {"rpy", Presence::optional, store_in(entry.rpy)},
                      {"quaternion", Presence::optional, store_in(entry.quaternion)},
                      {"set", Presence::optional, store_in(entry.set)},
                      {"without", Presence::optional, store_in(entry.without)}}))
      throw CascadingError();
    const std::filesystem::path name = entry.file->read_word("the file of a part");
    entry.folder = name.parent_path().string();
    read_copy_names(entry, document, names);
    const std::string file = (std::filesystem::path(path).parent_path() / name).lexically_normal().string();
    const YamlNode& part = part_of(file, *entry.file, document);
    const long size = count_nodes(part) + 10;
    for (std::size_t i = 0; i < entry.names.size(); ++i) {
      remaining_nodes_ -= size;
      if (remaining_nodes_ < 0)
        entry.names[i].fail(
            {.expected = fmt::format("at most {} values in a spec, including its parts", DocumentLimits{}.max_nodes)});
      problems_.collect([&] { insert_part(entry, part, i, document); });
    }
  }

  /// A part with its own parts inserted, reduced to the sections that are imported.
  const YamlNode& part_of(const std::string& file, const SpecCursor& at, const YamlNode& document) {
    if (std::find(chain_.begin(), chain_.end(), file) != chain_.end())
      at.fail({.expected = "a file that does not include itself",
               .found = fmt::format("{} → {}", fmt::join(chain_, " → "), file)});
    if (chain_.size() > max_include_depth)
      at.fail({.expected = fmt::format("parts nested at most {} deep", max_include_depth),
               .found = fmt::format("{} → {}", fmt::join(chain_, " → "), file)});
    const YamlNode& root = files_.load(file, at);
    if (!problems_.collect([&] { check_part(root, at, document); })) throw CascadingError();
    if (const auto match = parts_.find(file); match != parts_.end()) return match->second;
    YamlNode part = expand(root, file);
    for (const char* name : ignored_sections) erase_entry(part, name);
    return parts_.emplace(file, std::move(part)).first->second;
  }

  void check_part(const YamlNode& root, const SpecCursor& at, const YamlNode& document) {
    const SpecCursor part(root, "", problems_);
    // do not show the content of a file that is no part: a spec may name any file
    if (!part.is_map())
      part.fail({.expected = "a part: a mapping with 'space', 'bodies', 'joints', …", .found = "something else"});
    std::vector<Field> fields;
    for (const char* name : ignored_sections) fields.push_back({name, Presence::optional, [](const SpecCursor&) {}});
    fields[1].need = Presence::required;
    for (const char* name : imported_sections)
      fields.push_back({name, Presence::optional, [list = std::string(name)](const SpecCursor& c) {
                          const bool is_list = list == "couplings" || list == "actuators";
                          if (is_list ? !c.is_list() : !c.is_map()) c.fail_expected(is_list ? "a list" : "a mapping");
                        }});
    if (!read_fields(part, "a part", fields)) throw CascadingError();
    check_space_and_units(root, at, document);
  }

  /// Part and whole must have the same space and the same units.
  void check_space_and_units(const YamlNode& root, const SpecCursor& at, const YamlNode& document) {
    const YamlNode *space = find_entry(root, "space"), *own_space = find_entry(document, "space");
    if (own_space != nullptr && own_space->text != space->text)
      at.fail({.expected = fmt::format("a part whose space is {}, as in the including spec",
                                       quote_for_message(own_space->text)),
               .found = quote_for_message(space->text)});
    const auto units = [&](const YamlNode& node) {
      const YamlNode* section = find_entry(node, "units");
      return section == nullptr ? Units() : read_units(SpecCursor(*section, "units", problems_));
    };
    if (!is_same_units(units(root), units(document)))
      at.fail({.expected = "a part in the units of the including spec",
               .found = "different units in " + quote_for_message(problems_.file_of(root.place))});
  }

  SpecErrorCollector& problems_;
  PartFiles files_;
  std::map<std::string, YamlNode> parts_;  ///< by path, as in part_of()
  std::vector<std::string> chain_;         ///< files that are being read, each including the next
  long remaining_nodes_ = DocumentLimits{}.max_nodes;
};

/// Text of the document, with one entry of a section per line.
std::string text_of(const YamlNode& root, const std::string& file, const std::vector<std::string>& parts) {
  std::vector<std::string> names;
  for (const std::string& part : parts) names.push_back(std::filesystem::path(part).filename().string());
  std::string text = fmt::format("# {} combined with its parts: {}\n",
                                 escape_for_terminal(std::filesystem::path(file).filename().string()),
                                 escape_for_terminal(fmt::format("{}", fmt::join(names, ", "))));
  for (std::size_t i = 0; i < root.items.size(); ++i) {
    const YamlNode& section = root.items[i];
    text += format_scalar(root.keys[i].text) + ":";
    if (section.kind != YamlNode::Kind::map || section.items.empty()) {
      text += " " + format_flow(section) + "\n";
      continue;
    }
    text += "\n";
    for (std::size_t k = 0; k < section.items.size(); ++k)
      text += "  " + format_scalar(section.keys[k].text) + ": " + format_flow(section.items[k]) + "\n";
  }
  return text;
}

/// Sets the place of every node to where it was written, not to where it is in the combined text.
void set_places(YamlNode& flat, const YamlNode& written) {
  if (flat.items.size() != written.items.size() || flat.keys.size() != written.keys.size() || flat.text != written.text)
    throw std::logic_error("a spec with its parts reads otherwise than it was written");
  flat.place = written.place;
  for (std::size_t i = 0; i < flat.keys.size(); ++i) set_places(flat.keys[i], written.keys[i]);
  for (std::size_t i = 0; i < flat.items.size(); ++i) set_places(flat.items[i], written.items[i]);
}

}  // namespace

bool has_includes(const YamlNode& root) { return find_entry(root, "include") != nullptr; }

ExpandedDocument expand_includes(const YamlNode& root, const std::string& file, SpecErrorCollector& problems,
                                 const PartReader& text) {
  IncludeExpansion expansion(problems, text);
  YamlNode written;
  problems.collect([&] { written = expansion.expand(root, file); });
  problems.throw_if_any();
  ExpandedDocument flat{.files = expansion.files()};
  flat.text = text_of(written, file, flat.files);
  try {
    flat.root = parse_yaml(flat.text, problems);
  } catch (ReadError& error) {
    error.place = {1, 1};  // of the combined text, which nobody wrote
    throw;
  }
  set_places(flat.root, written);
  return flat;
}

namespace {

/// Limits above those of a valid spec.
constexpr int max_listed_parts = 200, max_part_depth = 10;

class FileListing {
 public:
  /// Adds all files that a document references, then those that its parts reference.
  void add(const std::string& text, const std::filesystem::path& folder) {
    // parsing takes much longer than this search; only escapes can hide the key
    if (text.find("file") == std::string::npos && text.find('\\') == std::string::npos) return;
    SpecErrorCollector problems("");
    YamlNode root;
    try {
      root = parse_yaml(text, problems);
    } catch (const ReadError&) {
      return;  // reading the spec reports what is wrong with it
    } catch (const SpecError&) {
      return;
    }
    if (root.kind != YamlNode::Kind::map) return;
    for (std::size_t i = 0; i < root.items.size(); ++i) visit(root.items[i], root.keys[i].text == "include", folder);
  }

  std::vector<std::string> take() { return std::move(files_); }

 private:
  void visit(const YamlNode& node, bool is_part, const std::filesystem::path& folder) {
    for (std::size_t i = 0; i < node.items.size(); ++i) {
      const YamlNode& item = node.items[i];
      const bool named =
          node.kind == YamlNode::Kind::map && node.keys[i].text == "file" && item.kind == YamlNode::Kind::scalar;
      if (named) add_file(folder / item.text, is_part);
      visit(item, is_part, folder);
    }
  }

  void add_file(const std::filesystem::path& path, bool is_part) {
    const std::string file = path.lexically_normal().string();
    if (std::find(files_.begin(), files_.end(), file) != files_.end()) return;
    files_.push_back(file);
    if (!is_part || depth_ == max_part_depth || ++parts_ > max_listed_parts) return;
    ++depth_;
    try {
      add(read_part_text(file), path.lexically_normal().parent_path());
    } catch (const SystemError&) {
      // reading the spec reports it
    }
    --depth_;
  }

  int parts_ = 0, depth_ = 0;
  std::vector<std::string> files_;
};

}  // namespace

std::vector<std::string> list_referenced_files(const std::string& spec_text, const std::string& spec_file) {
  FileListing listing;
  listing.add(spec_text, std::filesystem::path(spec_file).parent_path());
  return listing.take();
}

std::vector<std::string> list_spec_files(const std::string& spec_text, const std::string& spec_file) {
  std::vector<std::string> files;
  std::error_code ignored;
  const auto add = [&](const std::string& text) {
    for (std::string& file : list_referenced_files(text, spec_file)) files.push_back(std::move(file));
  };
  if (std::filesystem::is_regular_file(spec_file, ignored)) {
    files.push_back(spec_file);
    try {
      add(read_text_file(spec_file, "spec"));
    } catch (const SystemError&) {
      // the file is no longer readable, but the given text counts
    }
  }
  add(spec_text);
  return files;
}

namespace {

constexpr std::size_t max_part_files = 100;

void set_file(YamlNode& node, int file) {
  node.place.file = file;
  for (YamlNode& key : node.keys) set_file(key, file);
  for (YamlNode& item : node.items) set_file(item, file);
}

/// Reports mistakes in a part's text on their own.
YamlNode parse_part(const std::string& text, const std::string& path) {
  SpecErrorCollector errors(path);
  YamlNode root;
  try {
    root = parse_yaml(text, errors);
  } catch (const ReadError& error) {
    errors.add(error);
  }
  errors.throw_if_any();
  return root;
}

}  // namespace

std::string read_part_text(const std::string& path) {
  std::error_code error;
  if (!std::filesystem::exists(path, error)) throw SystemError(fmt::format("none at {}", quote_for_message(path)));
  if (const std::string kind = describe_non_file(path); !kind.empty())
    throw SystemError(fmt::format("{} at {}", kind, quote_for_message(path)));
  return read_text_file(path, "part");
}

const YamlNode& PartFiles::load(const std::string& path, const SpecCursor& at) {
  if (const auto match = documents_.find(path); match != documents_.end()) return match->second;
  if (documents_.size() >= max_part_files)
    at.fail({.expected = fmt::format("at most {} files in a spec", max_part_files)});
  std::string text;
  try {
    text = text_(path);
  } catch (const SystemError& error) {
    at.fail({.expected = "the file of a part", .found = error.what()});
  }
  YamlNode root = parse_part(text, path);
  set_file(root, problems_->add_file(path));
  return documents_.emplace(path, std::move(root)).first->second;
}

}  // namespace balance::specification
