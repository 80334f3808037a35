#include "balance/spec/open_parts.hpp"

#include <algorithm>

namespace balance::read {

namespace {

using Names = std::set<std::string>;

/// Whether some number in here depends on a free one; it may say yes where none does.
bool is_open(const Node& node, const Names& open_parameters) {
  if (node.kind == Node::Kind::scalar) {
    const auto names = names_in(node.text).values;
    return std::any_of(names.begin(), names.end(),
                       [&](const std::string& name) { return open_parameters.count(name) > 0; });
  }
  return std::any_of(node.keys.begin(), node.keys.end(), [](const Node& key) { return key.text == "free"; }) ||
         std::any_of(node.items.begin(), node.items.end(),
                     [&](const Node& item) { return is_open(item, open_parameters); });
}

const Node* find(const Node& map, const std::string& key) {
  for (std::size_t i = 0; i < map.keys.size(); ++i)
    if (map.keys[i].text == key) return &map.items[i];
  return nullptr;
}

/// Parameters that free numbers change.
Names open_parameters(const Node& root, const Parameters::Overrides& overrides) {
  Names open;
  if (find(root, "parameters") == nullptr) return open;
  Node section = *find(root, "parameters");
  for (const auto& [name, text] : overrides)
    for (std::size_t i = 0; i < section.items.size(); ++i)
      if (section.keys[i].text == name) {
        section.items[i].kind = Node::Kind::scalar;
        section.items[i].text = text;
      }
  // Each round finds those that depend on the ones found before.
  for (std::size_t before = 1; before != open.size();) {
    before = open.size();
    for (std::size_t i = 0; i < section.items.size(); ++i)
      if (is_open(section.items[i], open)) open.insert(section.keys[i].text);
  }
  return open;
}

/// Whether places that other sections name may move.
bool are_points_open(const Node& root, const Names& parameters) {
  const auto open = [&](const Node* body) {
    const Node* points = body == nullptr ? nullptr : find(*body, "points");
    return points != nullptr && is_open(*points, parameters);
  };
  const Node* bodies = find(root, "bodies");
  return open(find(root, "ground")) ||
         (bodies != nullptr &&
          std::any_of(bodies->items.begin(), bodies->items.end(), [&](const Node& body) { return open(&body); }));
}

}  // namespace

OpenParts find_open_parts(const Node& root, const Parameters::Overrides& overrides) {
  Names parameters = open_parameters(root, overrides), open;
  for (std::size_t i = 0; i < root.items.size(); ++i)
    if (is_open(root.items[i], parameters)) open.insert(root.keys[i].text);
  const auto has = [&](const char* name) { return open.count(name) > 0; };
  if (are_points_open(root, parameters))
    open.insert({"joints", "tool", "counterweights", "payloads", "discs", "loads", "springs"});
  // A disc turns about the axis of the joint that it follows.
  if (has("joints")) open.insert("discs");
  for (const auto& [one, other] :
       {std::pair{"ground", "bodies"}, {"counterweights", "payloads"}, {"motion", "trajectories"}})
    if (has(one) || has(other)) open.insert({one, other});
  return {std::move(parameters), std::move(open)};
}

}  // namespace balance::read
