#include "balance/spec/part_files.hpp"

#include "balance/base/nearest.hpp"
#include "balance/spec/text_file.hpp"

#include <fmt/format.h>

#include <filesystem>

namespace balance::specification {

namespace {

constexpr std::size_t max_part_files = 100;

void set_file(YamlNode& node, int file) {
  node.place.file = file;
  for (YamlNode& key : node.keys) set_file(key, file);
  for (YamlNode& item : node.items) set_file(item, file);
}

/// What is wrong with the text is told of it alone.
YamlNode parse_part(const std::string& text, const std::string& path) {
  SpecErrorCollector own(path);
  YamlNode root;
  try {
    root = parse_yaml(text, own);
  } catch (const ReadError& problem) {
    own.add(problem);
  }
  own.throw_if_any();
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
  if (const auto known = documents_.find(path); known != documents_.end()) return known->second;
  if (documents_.size() >= max_part_files)
    at.fail({.expected = fmt::format("at most {} files that a spec is made of", max_part_files)});
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
