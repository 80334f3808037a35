#include "balance/spec/named_files.hpp"

#include "balance/base/error.hpp"
#include "balance/spec/part_files.hpp"
#include "balance/spec/text_file.hpp"

#include <algorithm>
#include <filesystem>

namespace balance {

namespace specification {
namespace {

/// More than a spec may be made of.
constexpr int max_listed_parts = 200, max_part_depth = 10;

class FileListing {
 public:
  /// Everything that a document names, then what those name that are parts.
  void add(const std::string& text, const std::filesystem::path& folder) {
    // Reading takes much longer than looking; a key can be written otherwise only with escapes.
    if (text.find("file") == std::string::npos && text.find('\\') == std::string::npos) return;
    SpecErrorCollector problems("");
    YamlNode root;
    try {
      root = parse_yaml(text, problems);
    } catch (const ReadError&) {
      return;  // whoever reads the spec will say what is wrong with it
    } catch (const SpecError&) {
      return;
    }
    if (root.kind != YamlNode::Kind::map) return;
    for (std::size_t i = 0; i < root.items.size(); ++i) visit(root.items[i], root.keys[i].text == "include", folder);
  }

  std::vector<std::string> take() { return std::move(files_); }

 private:
  void visit(const YamlNode& node, bool part, const std::filesystem::path& folder) {
    for (std::size_t i = 0; i < node.items.size(); ++i) {
      const YamlNode& item = node.items[i];
      const bool named =
          node.kind == YamlNode::Kind::map && node.keys[i].text == "file" && item.kind == YamlNode::Kind::scalar;
      if (named) note(folder / item.text, part);
      visit(item, part, folder);
    }
  }

  void note(const std::filesystem::path& path, bool part) {
    const std::string file = path.lexically_normal().string();
    if (std::find(files_.begin(), files_.end(), file) != files_.end()) return;
    files_.push_back(file);
    if (!part || depth_ == max_part_depth || ++parts_ > max_listed_parts) return;
    ++depth_;
    try {
      add(read_part_text(file), path.lexically_normal().parent_path());
    } catch (const SystemError&) {
      // the reader's to complain about
    }
    --depth_;
  }

  int parts_ = 0, depth_ = 0;
  std::vector<std::string> files_;
};

}  // namespace
}  // namespace specification

std::vector<std::string> list_referenced_files(const std::string& spec_text, const std::string& spec_file) {
  specification::FileListing listing;
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
      // what was readable once still is what its text says
    }
  }
  add(spec_text);
  return files;
}

}  // namespace balance
