#include "balance/interface/import/foreign_readers.hpp"

#include "balance/foundation/base/spelling.hpp"
#include "balance/interface/import/xml_document.hpp"
#include "balance/interface/specification/text_file.hpp"
#include "balance/interface/specification/yaml_document.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <set>

namespace balance::foreign {

namespace {

namespace fs = std::filesystem;

constexpr std::size_t max_documents = 200;

bool is_file_key(const std::string& key) { return key.find("file") != key.npos || key == "uri" || key == "url"; }

class ReferencedFileCollector {
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
      // the reader of the file reports what is wrong with it
    } catch (const specification::ReadError&) {
    }
  }

  std::vector<std::string> list_files() { return {files_.begin(), files_.end()}; }

 private:
  void read_xml(const XmlElement& root, const fs::path& folder) {
    std::vector<fs::path> folders{folder};
    // MJCF names the folders of meshes and textures
    for (const XmlElement& element : root.children)
      for (const XmlAttribute& one : element.attributes)
        if (element.name == "compiler" && one.name.ends_with("dir")) folders.push_back(folder / one.value);
    visit(root, folders);
  }

  void visit(const XmlElement& element, const std::vector<fs::path>& folders) {
    for (const XmlAttribute& one : element.attributes)
      if (is_file_key(one.name)) add_reference(one.value, folders, element.name.ends_with("include"));
    if (is_file_key(element.name)) add_reference(element.text, folders, false);
    for (const XmlElement& child : element.children) visit(child, folders);
  }

  void read_yaml(const std::string& text, const fs::path& folder) {
    specification::SpecErrorCollector problems("");
    visit(specification::parse_yaml(text, problems), folder);
  }

  void visit(const specification::YamlNode& node, const fs::path& folder) {
    for (std::size_t i = 0; i < node.items.size(); ++i) {
      const specification::YamlNode& item = node.items[i];
      if (node.kind == specification::YamlNode::Kind::map && item.kind == specification::YamlNode::Kind::scalar &&
          is_file_key(node.keys[i].text))
        add_reference(item.text, {folder}, false);
      visit(item, folder);
    }
  }

  void add_reference(std::string name, const std::vector<fs::path>& folders, bool is_include) {
    const std::size_t scheme = name.find("://");
    const bool is_package = scheme != std::string::npos && !name.starts_with("file://");
    if (scheme != std::string::npos) name.erase(0, scheme + 3);
    if (name.empty()) return;
    for (const fs::path& folder : folders) add_file((folder / name).string(), is_include);
    if (!is_package) return;
    // a package is a folder above this file, or lies in one
    const fs::path path(name), package_path = path.lexically_relative(*path.begin());
    std::error_code error;
    const fs::path start_folder = fs::weakly_canonical(folders.front().empty() ? "." : folders.front(), error);
    for (fs::path ancestor = start_folder; !error; ancestor = ancestor.parent_path()) {
      add_file((ancestor / path).string(), false);
      add_file((ancestor / package_path).string(), false);
      if (!ancestor.has_relative_path()) break;
    }
  }

  void add_file(const std::string& file, bool is_include) {
    if (!files_.insert(file).second || !is_include) return;
    std::error_code error;
    if (!fs::is_regular_file(file, error)) return;
    try {
      read(specification::read_text_file(file, "included"), fs::path(file).parent_path());
    } catch (const SystemError&) {
      // the reader of the file reports it
    }
  }

  std::set<std::string> files_;
  std::size_t documents_ = 0;
};

}  // namespace

std::vector<std::string> list_referenced_robot_files(const std::string& text, const std::string& file) {
  ReferencedFileCollector collector;
  collector.read(text, std::filesystem::path(file).parent_path());
  return collector.list_files();
}

namespace {

ForeignModel read_xml(const std::string& text, const std::string& file) {
  const auto document = parse_xml(text, file);
  const std::string& root = document->root.name;
  if (root == "robot") return read_urdf(*document);
  if (root == "mujoco") return read_mjcf(*document);
  throw SpecError({.place = place_of(document->root),
                   .message = fmt::format("expected <robot> (URDF) or <mujoco> (MJCF), found <{}>", root)});
}

ForeignModel read_yaml(const std::string& text, const std::string& file) {
  specification::SpecErrorCollector problems(file);
  ForeignModel robot;
  try {
    const specification::YamlNode root = specification::parse_yaml(text, problems);
    const specification::SpecCursor cursor(root, "", problems);
    const auto has_key = [&](const char* key) {
      return std::any_of(root.keys.begin(), root.keys.end(),
                         [key](const specification::YamlNode& one) { return one.text == key; });
    };
    if (has_key("planar_bodies"))
      robot = read_mbse(cursor, file);
    else if (has_key("model") || has_key("chrono-version"))
      robot = read_chrono(cursor, file);
    else if (has_key("space") && has_key("joints"))
      cursor.fail({.expected = "a foreign file", .found = "a spec, which needs no import"});
    else
      cursor.fail_expected("URDF or MJCF (XML), MBSE ('points' and 'planar_bodies') or Chrono ('model')");
  } catch (const specification::ReadError& error) {
    problems.add(error);
  } catch (const specification::CascadingError&) {
  }
  problems.throw_if_any();
  return robot;
}

}  // namespace

ForeignModel read_foreign_model(const std::string& text, const std::string& file) {
  const std::size_t begin = text.rfind("\xEF\xBB\xBF", 0) == 0 ? 3 : 0;
  const std::size_t first = text.find_first_not_of(" \t\r\n", begin);
  const bool is_xml = first != std::string::npos && text[first] == '<';
  ForeignModel robot = is_xml ? read_xml(text, file) : read_yaml(text, file);
  for (const std::size_t count : {robot.bodies.size(), robot.joints.size()})
    if (count > max_model_elements)
      throw SpecError({.place = {file, 1, 1, ""},
                       .message = fmt::format("expected at most {} bodies and as many joints, found {}",
                                              max_model_elements, count)});
  return robot;
}

}  // namespace balance::foreign
