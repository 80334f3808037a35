#include "balance/spec/named_files.hpp"

#include "balance/base/error.hpp"
#include "balance/spec/node.hpp"
#include "balance/spec/problem.hpp"

namespace balance {

namespace read {
namespace {

void list_files(const Node& node, std::vector<std::string>& files) {
  for (std::size_t i = 0; i < node.items.size(); ++i) {
    const Node& item = node.items[i];
    const bool named = node.kind == Node::Kind::map && node.keys[i].text == "file" && item.kind == Node::Kind::scalar;
    if (named) files.push_back(item.text);
    list_files(item, files);
  }
}

}  // namespace
}  // namespace read

std::vector<std::string> files_named_in(const std::string& spec_text) {
  std::vector<std::string> files;
  // Reading takes much longer than looking; a key can be written otherwise only with escapes.
  if (spec_text.find("file") == std::string::npos && spec_text.find('\\') == std::string::npos) return files;
  read::Problems problems("");
  try {
    read::list_files(read::parse_yaml(spec_text, problems), files);
  } catch (const read::Problem&) {
    return {};  // whoever reads the spec will say what is wrong with it
  } catch (const SpecError&) {
    return {};
  }
  return files;
}

}  // namespace balance
