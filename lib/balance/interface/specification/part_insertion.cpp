#include "balance/interface/specification/part_insertion.hpp"

#include "balance/foundation/base/spelling.hpp"
#include "balance/foundation/base/unicode_text.hpp"
#include "balance/foundation/expression/expression_parser.hpp"
#include "balance/interface/specification/read_speeds.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <utility>

namespace balance::specification {

namespace {

bool is_declared_planar(const YamlNode& document) {
  const YamlNode* space = find_entry(document, "space");
  return space == nullptr || space->text != "spatial";
}

YamlNode map_node(const NodeLocation& place) { return {.kind = YamlNode::Kind::map, .place = place}; }

YamlNode list_node(const std::vector<std::string>& texts, const NodeLocation& place) {
  YamlNode list{.kind = YamlNode::Kind::list, .place = place};
  for (const std::string& text : texts) list.items.push_back(scalar_node(text, place));
  return list;
}

/// The mapping at a key, added if it does not exist.
YamlNode& map_at(YamlNode& map, const std::string& key, const NodeLocation& place) {
  if (find_entry(map, key) == nullptr) add_entry(map, scalar_node(key, place), map_node(place));
  return *find_entry(map, key);
}

std::vector<std::string> names_of_entries(const YamlNode* map) {
  std::vector<std::string> names;
  for (std::size_t i = 0; map != nullptr && i < map->keys.size(); ++i) names.push_back(map->keys[i].text);
  return names;
}

class PartInserter {
 public:
  PartInserter(const IncludeEntry& entry, std::size_t index, YamlNode& document)
      : entry_(entry), at_(entry.names[index]), first_(entry.names[0].node().text), document_(document) {
    placement_.name = at_.node().text;
    placement_.carrier = "ground";
    placement_.planar = is_declared_planar(document);
    placement_.folder = entry.folder;
    if (const auto on = value_for_copy(entry.on)) placement_.carrier = on->read_word("the body that carries a part");
    for (const auto& one : {entry.at, entry.angle, entry.rpy, entry.quaternion})
      if (value_for_copy(one)) placement_.is_fixed_body = true;
  }

  void insert(YamlNode part) {
    for (const SpecCursor& one : leave_out()) erase(part, one);
    rename_part(part, placement_);
    set_parameters(part);
    YamlNode points = take_points(part);
    if (placement_.is_fixed_body)
      fix_ground(part, std::move(points));
    else if (!points.items.empty())
      merge(carrier_points(), points);
    for (std::size_t i = 0; i < part.items.size(); ++i) merge_section(part.keys[i], part.items[i]);
  }

 private:
  const NodeLocation& place() const { return at_.node().place; }

  /// The value of a key for this copy, if any.
  std::optional<SpecCursor> value_for_copy(const std::optional<SpecCursor>& value) const {
    if (!value) return std::nullopt;
    if (!value->is_map() || find_entry(value->node(), "free") != nullptr) return value;
    std::vector<std::string> names;
    for (const SpecCursor& one : entry_.names) names.push_back(one.node().text);
    std::optional<SpecCursor> copy_value;
    for (const Member& member : list_members(*value, "a value, or one for each copy {name: value}")) {
      if (std::find(names.begin(), names.end(), member.name) == names.end())
        member.key.fail({.expected = fmt::format("one of the copies ({})", join_alternatives(names)),
                         .found = quote_for_message(member.name),
                         .hint = format_nearest_name(member.name, names)});
      if (member.name == placement_.name) copy_value = member.value;
    }
    return copy_value;
  }

  std::vector<SpecCursor> leave_out() const {
    if (!entry_.without) return {};
    return entry_.without->is_list() ? entry_.without->items("a list of names") : std::vector{*entry_.without};
  }

  /// Erases an entry such as `payloads`, `payloads.cargo` or `actuators.B`.
  static void erase(YamlNode& part, const SpecCursor& element) {
    const std::string& text = element.read_word("a section of the part, or section.name");
    const std::string section = text.substr(0, text.find('.'));
    const auto fail = [&](const std::vector<std::string>& names) {
      element.fail({.expected = fmt::format("the name of something in the part ({})",
                                            names.empty() ? "nothing" : join_alternatives(names)),
                    .found = quote_for_message(text),
                    .hint = format_nearest_name(text, names)});
    };
    YamlNode* node = find_entry(part, section);
    if (node == nullptr) fail(names_of_entries(&part));
    YamlNode& container = section == text ? part : *node;
    const std::string name = section == text ? text : text.substr(section.size() + 1);
    std::vector<std::string> names;
    for (std::size_t i = 0; i < container.items.size(); ++i) {
      const bool map = container.kind == YamlNode::Kind::map;
      names.push_back((section == text ? "" : section + ".") +
                      (map ? container.keys[i].text : container.items[i].text));
      if (names.back() != (section == text ? name : text)) continue;
      const auto offset = static_cast<std::ptrdiff_t>(i);
      if (map) container.keys.erase(container.keys.begin() + offset);
      container.items.erase(container.items.begin() + offset);
      return;
    }
    fail(names);
  }

  void set_parameters(YamlNode& part) const {
    if (!entry_.set) return;
    YamlNode* parameters = find_entry(part, "parameters");
    const std::string begin = placement_.name + ".";
    for (const Member& member : list_members(*entry_.set, "parameters of the part {name: value}")) {
      YamlNode* value = parameters == nullptr ? nullptr : find_entry(*parameters, begin + member.name);
      if (value == nullptr) {
        std::vector<std::string> names = names_of_entries(parameters);
        for (std::string& name : names) name.erase(0, begin.size());
        member.key.fail({.expected = fmt::format("a parameter of the part ({})",
                                                 names.empty() ? "there are none" : join_alternatives(names)),
                         .found = quote_for_message(member.name),
                         .hint = format_nearest_name(member.name, names)});
      }
      const auto copy_value = value_for_copy(member.value);
      if (!copy_value) continue;
      const bool shared = copy_value->is_scalar() && copy_value->node().text == "shared";
      if (!shared) *value = copy_value->node();
      if (shared && placement_.name != first_)
        *value = scalar_node(first_ + "." + member.name, copy_value->node().place);
    }
  }

  /// Removes the part's ground as a section and returns its points.
  static YamlNode take_points(YamlNode& part) {
    for (std::size_t i = 0; i < part.items.size(); ++i) {
      if (part.keys[i].text != "ground") continue;
      YamlNode points = map_node(part.items[i].place);
      if (YamlNode* part_points = find_entry(part.items[i], "points")) points = std::move(*part_points);
      part.keys.erase(part.keys.begin() + static_cast<std::ptrdiff_t>(i));
      part.items.erase(part.items.begin() + static_cast<std::ptrdiff_t>(i));
      return points;
    }
    return map_node(part.place);
  }

  YamlNode& carrier_points() {
    if (placement_.carrier == "ground") return map_at(map_at(document_, "ground", place()), "points", place());
    YamlNode* bodies = find_entry(document_, "bodies");
    YamlNode* carrier = bodies == nullptr ? nullptr : find_entry(*bodies, placement_.carrier);
    if (carrier != nullptr && carrier->kind == YamlNode::Kind::map) return map_at(*carrier, "points", place());
    std::vector<std::string> names = names_of_entries(bodies);
    names.insert(names.begin(), "ground");
    (value_for_copy(entry_.on) ? *value_for_copy(entry_.on) : at_)
        .fail({.expected = fmt::format("a body defined above the part ({})", join_alternatives(names)),
               .found = quote_for_message(placement_.carrier),
               .hint = format_nearest_name(placement_.carrier, names)});
  }

  /// Adds the part's ground as a massless body fixed to its carrier.
  void fix_ground(YamlNode& part, YamlNode points) {
    const YamlNode zero = list_node(std::vector<std::string>(placement_.planar ? 2 : 3, "0"), place());
    const auto position = value_for_copy(entry_.at);
    YamlNode mount_point = map_node(place());
    add_entry(mount_point, scalar_node(placement_.name, place()), position ? position->node() : zero);
    merge(carrier_points(), mount_point);
    const std::string body = placement_.name + ".ground";
    // its frame is at the origin of the part's ground, even if the part has another point `origin`
    const bool own_origin = find_entry(points, "origin") != nullptr;
    if (own_origin) add_entry(points, scalar_node("frame." + placement_.name, place()), zero);
    YamlNode ground = map_node(place());
    add_entry(ground, scalar_node("mass", place()), scalar_node("0", place()));
    add_entry(ground, scalar_node("points", place()), std::move(points));
    add_entry(map_at(part, "bodies", place()), scalar_node(body, place()), std::move(ground));
    YamlNode joint = map_node(place());
    add_entry(joint, scalar_node("type", place()), scalar_node("fixed", place()));
    add_entry(joint, scalar_node("connects", place()),
              list_node({placement_.carrier + "." + placement_.name,
                         body + (own_origin ? ".frame." + placement_.name : ".origin")},
                        place()));
    for (const auto& [key, value] :
         {std::pair{"angle", entry_.angle}, {"rpy", entry_.rpy}, {"quaternion", entry_.quaternion}})
      if (const auto copy_value = value_for_copy(value))
        add_entry(joint, scalar_node(key, place()), copy_value->node());
    add_entry(map_at(part, "joints", place()), scalar_node(body, place()), std::move(joint));
  }

  void merge_section(const YamlNode& key, YamlNode& section) {
    YamlNode* existing = find_entry(document_, key.text);
    if (existing == nullptr) return add_entry(document_, key, std::move(section));
    if (existing->kind != section.kind) {
      const SpecCursor at(*existing, key.text, at_.problems());
      at.fail_expected(section.kind == YamlNode::Kind::list ? "a list, as in the part" : "a mapping, as in the part");
    }
    if (section.kind == YamlNode::Kind::list)
      existing->items.insert(existing->items.end(), section.items.begin(), section.items.end());
    else
      merge(*existing, section, key.text == "assembly");
  }

  /// @param keep_existing the document's own entries take precedence
  void merge(YamlNode& target, YamlNode& source, bool keep_existing = false) const {
    if (target.kind != YamlNode::Kind::map) SpecCursor(target, "", at_.problems()).fail_expected("a mapping");
    for (std::size_t i = 0; i < source.items.size(); ++i) {
      if (find_entry(target, source.keys[i].text) == nullptr)
        add_entry(target, std::move(source.keys[i]), std::move(source.items[i]));
      else if (!keep_existing)
        at_.fail({.expected = "a name that makes all names of the part unique",
                  .found = fmt::format("{}, and {} twice", quote_for_message(placement_.name),
                                       quote_for_message(source.keys[i].text))});
    }
  }

  const IncludeEntry& entry_;
  const SpecCursor& at_;
  const std::string first_;
  YamlNode& document_;
  PartPlacement placement_;
};

}  // namespace

void read_copy_names(IncludeEntry& entry, const YamlNode& document, std::vector<std::string>& used_names) {
  const SpecCursor& as = *entry.as;
  entry.names = as.is_list() ? as.items("names of the copies") : std::vector{as};
  if (entry.names.empty()) as.fail_expected("at least one name");
  const std::vector<std::string> bodies = names_of_entries(find_entry(document, "bodies"));
  for (const SpecCursor& one : entry.names) {
    const std::string& name = one.read_word("the name of a copy");
    if (!is_unicode_identifier(name))
      one.fail({.expected = "a name of letters, digits, '_' and '-'", .found = quote_for_message(name)});
    const bool is_duplicate = std::find(used_names.begin(), used_names.end(), name) != used_names.end();
    const bool is_body = name == "ground" || std::find(bodies.begin(), bodies.end(), name) != bodies.end();
    if (is_duplicate || is_body || name == "free")
      one.fail({.expected = "an unused name",
                .found = quote_for_message(name) + (is_duplicate ? ", another copy's"
                                                    : is_body    ? ", a body's"
                                                                 : ", which is reserved")});
    used_names.push_back(name);
  }
}

void insert_part(const IncludeEntry& entry, YamlNode part, std::size_t index, YamlNode& document) {
  PartInserter(entry, index, document).insert(std::move(part));
}

namespace {

/// Meaning of a text in a section.
enum class ValueKind { number, word, reference, body, coordinate, file };

ValueKind value_kind(const std::string& key) {
  if (key == "connects" || key == "between") return ValueKind::reference;
  if (key == "body" || key == "on") return ValueKind::body;
  if (key == "follows" || key == "joint") return ValueKind::coordinate;
  if (key == "type" || key == "frame" || key == "about" || key == "interpolation" || key == "material")
    return ValueKind::word;
  return key == "file" || key == "catalogue" ? ValueKind::file : ValueKind::number;
}

class PartRenamer {
 public:
  explicit PartRenamer(const PartPlacement& placement) : placement_(placement) {}

  void run(YamlNode& part) {
    const YamlNode* joints = find_entry(part, "joints");
    has_joint_named_value_ = joints != nullptr && find_entry(*joints, constraint_value_key) != nullptr;
    for (std::size_t i = 0; i < part.items.size(); ++i) rename_section(part.keys[i].text, part.items[i]);
    if (needs_origin_) add_origin(part);
  }

 private:
  std::string prefixed(const std::string& name) const { return placement_.name + "." + name; }
  std::string body(const std::string& name) const {
    return name != "ground" || placement_.is_fixed_body ? prefixed(name) : placement_.carrier;
  }

  void rename_section(const std::string& name, YamlNode& section) {
    if (name == "ground") {
      if (YamlNode* points = find_entry(section, "points")) {
        has_origin_ = find_entry(*points, "origin") != nullptr;
        if (!placement_.is_fixed_body) prefix_keys(*points);
        rename_numbers(*points);
      }
    } else if (name == "bodies") {
      prefix_keys(section);
      for (YamlNode& element : section.items)
        for (std::size_t i = 0; i < element.keys.size(); ++i)
          element.keys[i].text == "points" ? rename_numbers(element.items[i])
                                           : rename_value(element.items[i], ValueKind::number);
    } else if (name == "actuators") {
      rename_value(section, ValueKind::coordinate);
    } else if (name == "couplings") {
      rename_value(section, ValueKind::number);
    } else if (name == "constraints") {
      prefix_keys(section);
      for (YamlNode& element : section.items) rename_speeds(element);
    } else {
      prefix_keys(section);
      for (YamlNode& element : section.items) rename_element(element);
    }
  }

  void prefix_keys(YamlNode& map) {
    for (YamlNode& key : map.keys) key.text = prefixed(key.text);
  }

  /// Sums of speeds: names of coordinates, or places with a component of their velocity, and
  /// factors. The tool is the whole's.
  void rename_speeds(YamlNode& sum) {
    const auto rename = [this](std::string& speed) {
      const std::size_t component = speed.rfind('.');
      if (speed.starts_with("tool.")) return;
      speed = speed.starts_with("ground.") && component > 7
                  ? reference(speed.substr(0, component)) + speed.substr(component)
                  : prefixed(speed);
    };
    if (sum.kind == YamlNode::Kind::scalar) rename(sum.text);
    for (std::size_t i = 0; i < sum.keys.size(); ++i) {
      const bool is_value = sum.keys[i].text == constraint_value_key && !has_joint_named_value_;
      if (!is_value) rename(sum.keys[i].text);
      if (!is_value)
        rename_value(sum.items[i], ValueKind::number);
      else
        sum.items[i].text = expression::rename_expression_values(
            sum.items[i].text, [this](const std::string& name) { return name == time_name ? name : prefixed(name); });
    }
  }

  /// An element with a position on a body: in it, coordinates are numbers and a text is a point.
  void rename_element(YamlNode& element) {
    bool on_ground = false;
    for (const char* key : {"body", "on"})
      if (const YamlNode* carrier = find_entry(element, key)) on_ground = carrier->text == "ground";
    YamlNode* at = find_entry(element, "at");
    const bool is_point_name = at != nullptr && at->kind == YamlNode::Kind::scalar;
    const std::string point_name = is_point_name ? at->text : "";
    rename_value(element, ValueKind::number);
    if (!is_point_name) return;
    at->text = point_name.find('.') != std::string::npos ? reference(point_name)
               : on_ground && !placement_.is_fixed_body  ? ground_point(point_name)
                                                         : point_name;
  }

  std::string ground_point(const std::string& name) {
    needs_origin_ = needs_origin_ || (name == "origin" && !has_origin_);
    return prefixed(name);
  }

  std::string reference(const std::string& text) {
    const bool on_ground = text.starts_with("ground.");
    return on_ground && !placement_.is_fixed_body ? placement_.carrier + "." + ground_point(text.substr(7))
                                                  : prefixed(text);
  }

  /// The carrier's `origin` is not the part's: adds the origin of the part's ground as a point.
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
    add_entry(*find_entry(*ground, "points"), scalar_node(prefixed("origin"), part.place), std::move(zero));
  }

  /// Keys are names without a meaning here.
  void rename_numbers(YamlNode& node) {
    if (node.kind == YamlNode::Kind::scalar) rename_text(node, ValueKind::number);
    for (YamlNode& item : node.items) rename_numbers(item);
  }

  void rename_value(YamlNode& node, ValueKind kind) {
    if (node.kind == YamlNode::Kind::scalar) rename_text(node, kind);
    for (std::size_t i = 0; i < node.items.size(); ++i) {
      const std::string key = i < node.keys.size() ? node.keys[i].text : "";
      if (key == "columns" || (kind == ValueKind::file && (key == "part" || key == "start")))
        continue;  // of a catalogue
      rename_value(node.items[i], i < node.keys.size() ? value_kind(key) : kind);
    }
  }

  void rename_text(YamlNode& node, ValueKind kind) {
    switch (kind) {
      case ValueKind::number: {
        const auto parameter = [this](const std::string& name) { return prefixed(name); };
        node.text = expression::rename_expression_values(node.text, parameter);
        break;
      }
      case ValueKind::reference: node.text = reference(node.text); break;
      case ValueKind::body: node.text = body(node.text); break;
      case ValueKind::coordinate: node.text = prefixed(node.text); break;
      case ValueKind::file: node.text = (std::filesystem::path(placement_.folder) / node.text).string(); break;
      case ValueKind::word: break;
    }
  }

  const PartPlacement& placement_;
  bool has_origin_ = false, needs_origin_ = false, has_joint_named_value_ = false;
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
