#include "balance/spec/part_names.hpp"

#include "balance/expression/parse.hpp"

#include <filesystem>
#include <utility>

namespace balance::specification {

namespace {

/// What a text in a section says.
enum class ValueKind { number, word, reference, body, coordinate, file };

ValueKind value_kind(const std::string& key) {
  if (key == "connects" || key == "between") return ValueKind::reference;
  if (key == "body" || key == "on") return ValueKind::body;
  if (key == "follows" || key == "joint") return ValueKind::coordinate;
  if (key == "type" || key == "frame" || key == "about") return ValueKind::word;
  return key == "file" ? ValueKind::file : ValueKind::number;
}

class PartRenamer {
 public:
  explicit PartRenamer(const PartPlacement& placement) : placement_(placement) {}

  void run(YamlNode& part) {
    for (std::size_t i = 0; i < part.items.size(); ++i) section(part.keys[i].text, part.items[i]);
    if (needs_origin_) add_origin(part);
  }

 private:
  std::string own(const std::string& name) const { return placement_.name + "." + name; }
  std::string body(const std::string& name) const {
    return name != "ground" || placement_.is_fixed_body ? own(name) : placement_.carrier;
  }

  void section(const std::string& name, YamlNode& section) {
    if (name == "ground") {
      if (YamlNode* points = find_entry(section, "points")) {
        has_origin_ = find_entry(*points, "origin") != nullptr;
        if (!placement_.is_fixed_body) prefix_keys(*points);
        numbers(*points);
      }
    } else if (name == "bodies") {
      prefix_keys(section);
      for (YamlNode& one : section.items)
        for (std::size_t i = 0; i < one.keys.size(); ++i)
          one.keys[i].text == "points" ? numbers(one.items[i]) : value(one.items[i], ValueKind::number);
    } else if (name == "actuators") {
      value(section, ValueKind::coordinate);
    } else if (name == "couplings") {
      value(section, ValueKind::number);
    } else if (name == "constraints") {
      prefix_keys(section);
      for (YamlNode& one : section.items) speeds(one);
    } else {
      prefix_keys(section);
      for (YamlNode& one : section.items) fixture(one);
    }
  }

  void prefix_keys(YamlNode& map) {
    for (YamlNode& key : map.keys) key.text = own(key.text);
  }

  /// Sums of speeds: names of coordinates, or places with a component of their motion, and factors. The tool is the whole's.
  void speeds(YamlNode& sum) {
    const auto rename = [this](std::string& speed) {
      const std::size_t component = speed.rfind('.');
      if (speed.starts_with("tool.")) return;
      speed = speed.starts_with("ground.") && component > 7
                  ? reference(speed.substr(0, component)) + speed.substr(component)
                  : own(speed);
    };
    if (sum.kind == YamlNode::Kind::scalar) rename(sum.text);
    for (YamlNode& key : sum.keys) rename(key.text);
    for (YamlNode& factor : sum.items) value(factor, ValueKind::number);
  }

  /// Something with a place on a body: there, coordinates are numbers and a text is a point.
  void fixture(YamlNode& one) {
    bool on_ground = false;
    for (const char* key : {"body", "on"})
      if (const YamlNode* carrier = find_entry(one, key)) on_ground = carrier->text == "ground";
    YamlNode* at = find_entry(one, "at");
    const bool point = at != nullptr && at->kind == YamlNode::Kind::scalar;
    const std::string text = point ? at->text : "";
    value(one, ValueKind::number);
    if (!point) return;
    at->text = text.find('.') != std::string::npos      ? reference(text)
               : on_ground && !placement_.is_fixed_body ? ground_point(text)
                                                        : text;
  }

  std::string ground_point(const std::string& name) {
    needs_origin_ = needs_origin_ || (name == "origin" && !has_origin_);
    return own(name);
  }

  std::string reference(const std::string& text) {
    const bool on_ground = text.starts_with("ground.");
    return on_ground && !placement_.is_fixed_body ? placement_.carrier + "." + ground_point(text.substr(7)) : own(text);
  }

  /// A body defines no `origin` for the part: where the part's ground has its own one is then a point.
  void add_origin(YamlNode& part) const {
    YamlNode* ground = find_entry(part, "ground");
    if (ground == nullptr) {
      add_entry(part, scalar_node("ground", part.place), {.kind = YamlNode::Kind::map, .place = part.place});
      ground = &part.items.back();
    }
    if (find_entry(*ground, "points") == nullptr)
      add_entry(*ground, scalar_node("points", part.place), {.kind = YamlNode::Kind::map, .place = part.place});
    YamlNode zero{.kind = YamlNode::Kind::list, .place = part.place};
    zero.items.assign(placement_.planar ? 2 : 3, scalar_node("0", part.place));
    add_entry(*find_entry(*ground, "points"), scalar_node(own("origin"), part.place), std::move(zero));
  }

  /// Keys are names that mean nothing here.
  void numbers(YamlNode& node) {
    if (node.kind == YamlNode::Kind::scalar) text(node, ValueKind::number);
    for (YamlNode& item : node.items) numbers(item);
  }

  void value(YamlNode& node, ValueKind use) {
    if (node.kind == YamlNode::Kind::scalar) text(node, use);
    for (std::size_t i = 0; i < node.items.size(); ++i)
      value(node.items[i], i < node.keys.size() ? value_kind(node.keys[i].text) : use);
  }

  void text(YamlNode& node, ValueKind use) {
    switch (use) {
      case ValueKind::number: {
        const auto parameter = [this](const std::string& name) { return own(name); };
        node.text = rename_expression_values(node.text, parameter);
        break;
      }
      case ValueKind::reference: node.text = reference(node.text); break;
      case ValueKind::body: node.text = body(node.text); break;
      case ValueKind::coordinate: node.text = own(node.text); break;
      case ValueKind::file: node.text = (std::filesystem::path(placement_.folder) / node.text).string(); break;
      case ValueKind::word: break;
    }
  }

  const PartPlacement& placement_;
  bool has_origin_ = false, needs_origin_ = false;
};

}  // namespace

void rename_part(YamlNode& part, const PartPlacement& placement) { PartRenamer(placement).run(part); }

YamlNode* find_entry(YamlNode& map, const std::string& key) {
  for (std::size_t i = 0; map.kind == YamlNode::Kind::map && i < map.items.size(); ++i)
    if (map.keys[i].text == key) return &map.items[i];
  return nullptr;
}

const YamlNode* find_entry(const YamlNode& map, const std::string& key) {
  return find_entry(const_cast<YamlNode&>(map), key);
}

YamlNode scalar_node(std::string text, const NodeLocation& place) {
  return {.kind = YamlNode::Kind::scalar, .place = place, .text = std::move(text)};
}

void add_entry(YamlNode& map, YamlNode key, YamlNode value) {
  map.keys.push_back(std::move(key));
  map.items.push_back(std::move(value));
}

}  // namespace balance::specification
