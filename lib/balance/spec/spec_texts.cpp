#include "balance/spec/spec_texts.hpp"

#include "balance/spec/node.hpp"

namespace balance {

namespace {

using read::Node;

void collect(const Node& node, const std::string& path, SpecTexts& texts) {
  if (node.kind == Node::Kind::scalar) texts.numbers[path] = node.text;
  for (std::size_t i = 0; i < node.items.size(); ++i) {
    const bool map = node.kind == Node::Kind::map;
    const std::string key = map ? (path.empty() ? "" : ".") + node.keys[i].text : "[" + std::to_string(i) + "]";
    collect(node.items[i], path + key, texts);
  }
}

const Node* member(const Node& map, const std::string& key) {
  for (std::size_t i = 0; map.kind == Node::Kind::map && i < map.items.size(); ++i)
    if (map.keys[i].text == key) return &map.items[i];
  return nullptr;
}

/// A free number's start is the middle of its bounds unless it is given.
std::string value_text(const Node& value) {
  if (value.kind == Node::Kind::scalar) return value.text;
  if (const Node* start = member(value, "start")) return start->text;
  const Node* bounds = member(value, "free");
  if (bounds == nullptr || bounds->items.size() != 2) return "";
  return "(" + bounds->items[0].text + " + " + bounds->items[1].text + ") / 2";
}

}  // namespace

SpecTexts read_spec_texts(const DesignSpace& space, const ReadOptions& options) {
  SpecTexts texts;
  texts.recording = space.recording;
  read::Problems problems("");
  const Node root = read::parse_yaml(space.start.spec_text, problems);
  collect(root, "", texts);
  if (const Node* section = member(root, "parameters"); section != nullptr && section->kind == Node::Kind::map)
    for (std::size_t i = 0; i < section->items.size(); ++i)
      texts.parameters.push_back({section->keys[i].text, value_text(section->items[i])});
  for (const auto& [name, value] : options.set) {
    texts.numbers[name] = value;
    for (ParameterText& parameter : texts.parameters)
      if (parameter.name == name) parameter.text = value;
  }
  return texts;
}

}  // namespace balance
