#include "balance/spec/part_names.hpp"

#include "balance/expression/parse.hpp"

#include <filesystem>
#include <utility>

namespace balance::read {

namespace {

/// What a text in a section says.
enum class Use { number, word, reference, body, coordinate, file };

Use use_of(const std::string& key) {
  if (key == "connects" || key == "between") return Use::reference;
  if (key == "body" || key == "on") return Use::body;
  if (key == "follows" || key == "joint") return Use::coordinate;
  if (key == "type" || key == "frame" || key == "about") return Use::word;
  return key == "file" ? Use::file : Use::number;
}

class Renamer {
 public:
  explicit Renamer(const Placement& placement) : placement_(placement) {}

  void run(Node& part) {
    for (std::size_t i = 0; i < part.items.size(); ++i) section(part.keys[i].text, part.items[i]);
    if (needs_origin_) add_origin(part);
  }

 private:
  std::string own(const std::string& name) const { return placement_.name + "." + name; }
  std::string body(const std::string& name) const {
    return name != "ground" || placement_.fixed ? own(name) : placement_.carrier;
  }

  void section(const std::string& name, Node& section) {
    if (name == "ground") {
      if (Node* points = find_entry(section, "points")) {
        has_origin_ = find_entry(*points, "origin") != nullptr;
        if (!placement_.fixed) prefix_keys(*points);
        numbers(*points);
      }
    } else if (name == "bodies") {
      prefix_keys(section);
      for (Node& one : section.items)
        for (std::size_t i = 0; i < one.keys.size(); ++i)
          one.keys[i].text == "points" ? numbers(one.items[i]) : value(one.items[i], Use::number);
    } else if (name == "actuators") {
      value(section, Use::coordinate);
    } else if (name == "couplings") {
      value(section, Use::number);
    } else if (name == "constraints") {
      prefix_keys(section);
      for (Node& one : section.items) speeds(one);
    } else {
      prefix_keys(section);
      for (Node& one : section.items) fixture(one);
    }
  }

  void prefix_keys(Node& map) {
    for (Node& key : map.keys) key.text = own(key.text);
  }

  /// Sums of speeds: names of coordinates, or places with a component of their motion, and factors. The tool is the whole's.
  void speeds(Node& sum) {
    const auto rename = [this](std::string& speed) {
      const std::size_t component = speed.rfind('.');
      if (speed.starts_with("tool.")) return;
      speed = speed.starts_with("ground.") && component > 7
                  ? reference(speed.substr(0, component)) + speed.substr(component)
                  : own(speed);
    };
    if (sum.kind == Node::Kind::scalar) rename(sum.text);
    for (Node& key : sum.keys) rename(key.text);
    for (Node& factor : sum.items) value(factor, Use::number);
  }

  /// Something with a place on a body: there, coordinates are numbers and a text is a point.
  void fixture(Node& one) {
    bool on_ground = false;
    for (const char* key : {"body", "on"})
      if (const Node* carrier = find_entry(one, key)) on_ground = carrier->text == "ground";
    Node* at = find_entry(one, "at");
    const bool point = at != nullptr && at->kind == Node::Kind::scalar;
    const std::string text = point ? at->text : "";
    value(one, Use::number);
    if (!point) return;
    at->text = text.find('.') != std::string::npos ? reference(text)
               : on_ground && !placement_.fixed    ? ground_point(text)
                                                   : text;
  }

  std::string ground_point(const std::string& name) {
    needs_origin_ = needs_origin_ || (name == "origin" && !has_origin_);
    return own(name);
  }

  std::string reference(const std::string& text) {
    const bool on_ground = text.starts_with("ground.");
    return on_ground && !placement_.fixed ? placement_.carrier + "." + ground_point(text.substr(7)) : own(text);
  }

  /// A body defines no `origin` for the part: where the part's ground has its own one is then a point.
  void add_origin(Node& part) const {
    Node* ground = find_entry(part, "ground");
    if (ground == nullptr) {
      add_entry(part, scalar_node("ground", part.place), {.kind = Node::Kind::map, .place = part.place});
      ground = &part.items.back();
    }
    if (find_entry(*ground, "points") == nullptr)
      add_entry(*ground, scalar_node("points", part.place), {.kind = Node::Kind::map, .place = part.place});
    Node zero{.kind = Node::Kind::list, .place = part.place};
    zero.items.assign(placement_.planar ? 2 : 3, scalar_node("0", part.place));
    add_entry(*find_entry(*ground, "points"), scalar_node(own("origin"), part.place), std::move(zero));
  }

  /// Keys are names that mean nothing here.
  void numbers(Node& node) {
    if (node.kind == Node::Kind::scalar) text(node, Use::number);
    for (Node& item : node.items) numbers(item);
  }

  void value(Node& node, Use use) {
    if (node.kind == Node::Kind::scalar) text(node, use);
    for (std::size_t i = 0; i < node.items.size(); ++i)
      value(node.items[i], i < node.keys.size() ? use_of(node.keys[i].text) : use);
  }

  void text(Node& node, Use use) {
    switch (use) {
      case Use::number: {
        const auto parameter = [this](const std::string& name) { return own(name); };
        node.text = with_names(node.text, parameter);
        break;
      }
      case Use::reference: node.text = reference(node.text); break;
      case Use::body: node.text = body(node.text); break;
      case Use::coordinate: node.text = own(node.text); break;
      case Use::file: node.text = (std::filesystem::path(placement_.folder) / node.text).string(); break;
      case Use::word: break;
    }
  }

  const Placement& placement_;
  bool has_origin_ = false, needs_origin_ = false;
};

}  // namespace

void rename_part(Node& part, const Placement& placement) { Renamer(placement).run(part); }

Node* find_entry(Node& map, const std::string& key) {
  for (std::size_t i = 0; map.kind == Node::Kind::map && i < map.items.size(); ++i)
    if (map.keys[i].text == key) return &map.items[i];
  return nullptr;
}

const Node* find_entry(const Node& map, const std::string& key) { return find_entry(const_cast<Node&>(map), key); }

Node scalar_node(std::string text, const Place& place) {
  return {.kind = Node::Kind::scalar, .place = place, .text = std::move(text)};
}

void add_entry(Node& map, Node key, Node value) {
  map.keys.push_back(std::move(key));
  map.items.push_back(std::move(value));
}

}  // namespace balance::read
