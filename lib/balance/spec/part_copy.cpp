#include "balance/spec/part_copy.hpp"

#include "balance/base/nearest.hpp"
#include "balance/base/plain_text.hpp"

#include <fmt/format.h>

#include <algorithm>
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

/// A mapping that is there, or is added.
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

  /// What a key says for this copy, if anything.
  std::optional<SpecCursor> value_for_copy(const std::optional<SpecCursor>& value) const {
    if (!value) return std::nullopt;
    if (!value->is_map() || find_entry(value->node(), "free") != nullptr) return value;
    std::vector<std::string> names;
    for (const SpecCursor& one : entry_.names) names.push_back(one.node().text);
    std::optional<SpecCursor> own;
    for (const Member& member : list_members(*value, "a value, or one for each copy {name: value}")) {
      if (std::find(names.begin(), names.end(), member.name) == names.end())
        member.key.fail({.expected = fmt::format("one of the copies ({})", join_alternatives(names)),
                         .found = quote_for_message(member.name),
                         .hint = format_nearest_name(member.name, names)});
      if (member.name == placement_.name) own = member.value;
    }
    return own;
  }

  std::vector<SpecCursor> leave_out() const {
    if (!entry_.without) return {};
    return entry_.without->is_list() ? entry_.without->items("a list of names") : std::vector{*entry_.without};
  }

  /// `payloads`, `payloads.cargo`, `actuators.B`.
  static void erase(YamlNode& part, const SpecCursor& what) {
    const std::string& text = what.read_word("a section of the part, or section.name");
    const std::string section = text.substr(0, text.find('.'));
    const auto fail = [&](const std::vector<std::string>& names) {
      what.fail({.expected = fmt::format("something that the part has ({})",
                                         names.empty() ? "nothing" : join_alternatives(names)),
                 .found = quote_for_message(text),
                 .hint = format_nearest_name(text, names)});
    };
    YamlNode* node = find_entry(part, section);
    if (node == nullptr) fail(names_of_entries(&part));
    YamlNode& holder = section == text ? part : *node;
    const std::string name = section == text ? text : text.substr(section.size() + 1);
    std::vector<std::string> names;
    for (std::size_t i = 0; i < holder.items.size(); ++i) {
      const bool map = holder.kind == YamlNode::Kind::map;
      names.push_back((section == text ? "" : section + ".") + (map ? holder.keys[i].text : holder.items[i].text));
      if (names.back() != (section == text ? name : text)) continue;
      const auto place = static_cast<std::ptrdiff_t>(i);
      if (map) holder.keys.erase(holder.keys.begin() + place);
      holder.items.erase(holder.items.begin() + place);
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
      const auto own = value_for_copy(member.value);
      if (!own) continue;
      const bool shared = own->is_scalar() && own->node().text == "shared";
      if (!shared) *value = own->node();
      if (shared && placement_.name != first_) *value = scalar_node(first_ + "." + member.name, own->node().place);
    }
  }

  /// Of the part's ground, which is no section any more.
  static YamlNode take_points(YamlNode& part) {
    for (std::size_t i = 0; i < part.items.size(); ++i) {
      if (part.keys[i].text != "ground") continue;
      YamlNode points = map_node(part.items[i].place);
      if (YamlNode* said = find_entry(part.items[i], "points")) points = std::move(*said);
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
        .fail({.expected = fmt::format("a body that stands above the part ({})", join_alternatives(names)),
               .found = quote_for_message(placement_.carrier),
               .hint = format_nearest_name(placement_.carrier, names)});
  }

  /// The part's ground as a body without mass that is fixed to its carrier.
  void fix_ground(YamlNode& part, YamlNode points) {
    const YamlNode zero = list_node(std::vector<std::string>(placement_.planar ? 2 : 3, "0"), place());
    const auto where = value_for_copy(entry_.at);
    YamlNode stand = map_node(place());
    add_entry(stand, scalar_node(placement_.name, place()), where ? where->node() : zero);
    merge(carrier_points(), stand);
    const std::string body = placement_.name + ".ground";
    // Its frame is where the part's ground has its origin, whatever the part calls `origin`.
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
      if (const auto own = value_for_copy(value)) add_entry(joint, scalar_node(key, place()), own->node());
    add_entry(map_at(part, "joints", place()), scalar_node(body, place()), std::move(joint));
  }

  void merge_section(const YamlNode& key, YamlNode& section) {
    YamlNode* own = find_entry(document_, key.text);
    if (own == nullptr) return add_entry(document_, key, std::move(section));
    if (own->kind != section.kind) {
      const SpecCursor at(*own, key.text, at_.problems());
      at.fail_expected(section.kind == YamlNode::Kind::list ? "a list, as the part has it"
                                                            : "a mapping, as the part has it");
    }
    if (section.kind == YamlNode::Kind::list)
      own->items.insert(own->items.end(), section.items.begin(), section.items.end());
    else
      merge(*own, section, key.text == "assembly");
  }

  /// @param weak the document's own entries stay
  void merge(YamlNode& into, YamlNode& from, bool weak = false) const {
    if (into.kind != YamlNode::Kind::map) SpecCursor(into, "", at_.problems()).fail_expected("a mapping");
    for (std::size_t i = 0; i < from.items.size(); ++i) {
      if (find_entry(into, from.keys[i].text) == nullptr)
        add_entry(into, std::move(from.keys[i]), std::move(from.items[i]));
      else if (!weak)
        at_.fail({.expected = "a name that makes all names of the part new",
                  .found = fmt::format("{}, and {} twice", quote_for_message(placement_.name),
                                       quote_for_message(from.keys[i].text))});
    }
  }

  const IncludeEntry& entry_;
  const SpecCursor& at_;
  const std::string first_;
  YamlNode& document_;
  PartPlacement placement_;
};

}  // namespace

void read_copy_names(IncludeEntry& entry, const YamlNode& document, std::vector<std::string>& taken) {
  const SpecCursor& as = *entry.as;
  entry.names = as.is_list() ? as.items("names of the copies") : std::vector{as};
  if (entry.names.empty()) as.fail_expected("at least one name");
  const std::vector<std::string> bodies = names_of_entries(find_entry(document, "bodies"));
  for (const SpecCursor& one : entry.names) {
    const std::string& name = one.read_word("the name of a copy");
    if (!is_unicode_identifier(name))
      one.fail({.expected = "a name of letters, digits, '_' and '-'", .found = quote_for_message(name)});
    const bool again = std::find(taken.begin(), taken.end(), name) != taken.end();
    const bool body = name == "ground" || std::find(bodies.begin(), bodies.end(), name) != bodies.end();
    if (again || body || name == "free")
      one.fail({.expected = "a name of its own",
                .found = quote_for_message(name) + (again  ? ", another copy's"
                                                    : body ? ", a body's"
                                                           : ", which has a meaning")});
    taken.push_back(name);
  }
}

void insert_part(const IncludeEntry& entry, YamlNode part, std::size_t index, YamlNode& document) {
  PartInserter(entry, index, document).insert(std::move(part));
}

}  // namespace balance::specification
