#include "balance/import/source_files.hpp"

#include "balance/import/xml_document.hpp"
#include "balance/spec/node.hpp"
#include "balance/spec/text_file.hpp"

#include <algorithm>
#include <filesystem>
#include <set>

namespace balance {

namespace foreign {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t max_documents = 200;

bool names_file(const std::string& key) { return key.find("file") != key.npos || key == "uri" || key == "url"; }

class SourceListing {
 public:
  void read(const std::string& text, const fs::path& folder) {
    if (++documents_ > max_documents) return;
    try {
      const std::size_t first = text.find_first_not_of("\xEF\xBB\xBF \t\r\n");
      if (first != std::string::npos && text[first] == '<')
        read_xml(parse_xml(text, "")->root, folder);
      else
        read_yaml(text, folder);
    } catch (const SpecError&) {
      // what is wrong with it is the reader's to say
    } catch (const read::Problem&) {
    }
  }

  std::vector<std::string> take() { return {files_.begin(), files_.end()}; }

 private:
  void read_xml(const XmlElement& root, const fs::path& folder) {
    std::vector<fs::path> folders{folder};
    // MJCF says where meshes and textures lie
    for (const XmlElement& part : root.children)
      for (const XmlAttribute& one : part.attributes)
        if (part.name == "compiler" && one.name.ends_with("dir")) folders.push_back(folder / one.value);
    visit(root, folders);
  }

  void visit(const XmlElement& element, const std::vector<fs::path>& folders) {
    for (const XmlAttribute& one : element.attributes)
      if (names_file(one.name)) note(one.value, folders, element.name.ends_with("include"));
    if (names_file(element.name)) note(element.text, folders, false);
    for (const XmlElement& child : element.children) visit(child, folders);
  }

  void read_yaml(const std::string& text, const fs::path& folder) {
    read::Problems problems("");
    visit(read::parse_yaml(text, problems), folder);
  }

  void visit(const read::Node& node, const fs::path& folder) {
    for (std::size_t i = 0; i < node.items.size(); ++i) {
      const read::Node& item = node.items[i];
      if (node.kind == read::Node::Kind::map && item.kind == read::Node::Kind::scalar && names_file(node.keys[i].text))
        note(item.text, {folder}, false);
      visit(item, folder);
    }
  }

  void note(std::string name, const std::vector<fs::path>& folders, bool include) {
    const std::size_t scheme = name.find("://");
    const bool package = scheme != std::string::npos && !name.starts_with("file://");
    if (scheme != std::string::npos) name.erase(0, scheme + 3);
    if (name.empty()) return;
    for (const fs::path& folder : folders) add((folder / name).string(), include);
    if (!package) return;
    // a package is a folder above this file, or beside one
    const fs::path path(name), inside = path.lexically_relative(*path.begin());
    std::error_code error;
    const fs::path begin = fs::weakly_canonical(folders.front().empty() ? "." : folders.front(), error);
    for (fs::path above = begin; !error; above = above.parent_path()) {
      add((above / path).string(), false);
      add((above / inside).string(), false);
      if (!above.has_relative_path()) break;
    }
  }

  void add(const std::string& file, bool include) {
    if (!files_.insert(file).second || !include) return;
    std::error_code error;
    if (!fs::is_regular_file(file, error)) return;
    try {
      read(read_text_file(file, "included"), fs::path(file).parent_path());
    } catch (const SystemError&) {
      // the reader's to complain about
    }
  }

  std::set<std::string> files_;
  std::size_t documents_ = 0;
};

}  // namespace
}  // namespace foreign

std::vector<std::string> files_named_by_robot(const std::string& text, const std::string& file) {
  foreign::SourceListing listing;
  listing.read(text, std::filesystem::path(file).parent_path());
  return listing.take();
}

}  // namespace balance
