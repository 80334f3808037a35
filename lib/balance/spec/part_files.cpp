#include "balance/spec/part_files.hpp"

#include "balance/base/nearest.hpp"
#include "balance/spec/text_file.hpp"

#include <fmt/format.h>

#include <filesystem>

namespace balance::read {

namespace {

constexpr std::size_t most_files = 100;

void set_file(Node& node, int file) {
  node.place.file = file;
  for (Node& key : node.keys) set_file(key, file);
  for (Node& item : node.items) set_file(item, file);
}

/// What is wrong with the text is told of it alone.
Node parse_part(const std::string& text, const std::string& path) {
  Problems own(path);
  Node root;
  try {
    root = parse_yaml(text, own);
  } catch (const Problem& problem) {
    own.add(problem);
  }
  own.throw_all();
  return root;
}

}  // namespace

std::string read_part_text(const std::string& path) {
  std::error_code error;
  if (!std::filesystem::exists(path, error)) throw SystemError(fmt::format("none at {}", in_quotes(path)));
  if (const std::string kind = kind_of_no_file(path); !kind.empty())
    throw SystemError(fmt::format("{} at {}", kind, in_quotes(path)));
  return read_text_file(path, "part");
}

const Node& PartFiles::load(const std::string& path, const Cursor& at) {
  if (const auto known = documents_.find(path); known != documents_.end()) return known->second;
  if (documents_.size() >= most_files)
    at.fail({.expected = fmt::format("at most {} files that a spec is made of", most_files)});
  std::string text;
  try {
    text = text_(path);
  } catch (const SystemError& error) {
    at.fail({.expected = "the file of a part", .found = error.what()});
  }
  Node root = parse_part(text, path);
  set_file(root, problems_->add_file(path));
  return documents_.emplace(path, std::move(root)).first->second;
}

}  // namespace balance::read
