#include "balance/spec/part_copy.hpp"

#include "balance/base/nearest.hpp"
#include "balance/base/plain_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace balance::read {

namespace {

bool says_planar(const Node& document) {
  const Node* space = find_entry(document, "space");
  return space == nullptr || space->text != "spatial";
}

Node map_node(const Place& place) { return {.kind = Node::Kind::map, .place = place}; }

Node list_node(const std::vector<std::string>& texts, const Place& place) {
  Node list{.kind = Node::Kind::list, .place = place};
  for (const std::string& text : texts) list.items.push_back(scalar_node(text, place));
  return list;
}

/// A mapping that is there, or is added.
Node& map_at(Node& map, const std::string& key, const Place& place) {
  if (find_entry(map, key) == nullptr) add_entry(map, scalar_node(key, place), map_node(place));
  return *find_entry(map, key);
}

std::vector<std::string> names_of_entries(const Node* map) {
  std::vector<std::string> names;
  for (std::size_t i = 0; map != nullptr && i < map->keys.size(); ++i) names.push_back(map->keys[i].text);
  return names;
}

class Copy {
 public:
  Copy(const PartEntry& entry, std::size_t index, Node& document)
      : entry_(entry), at_(entry.names[index]), first_(entry.names[0].node().text), document_(document) {
    placement_.name = at_.node().text;
    placement_.carrier = "ground";
    placement_.planar = says_planar(document);
    placement_.folder = entry.folder;
    if (const auto on = said(entry.on)) placement_.carrier = on->word("the body that carries a part");
    for (const auto& one : {entry.at, entry.angle, entry.rpy, entry.quaternion})
      if (said(one)) placement_.fixed = true;
  }

  void put(Node part) {
    for (const Cursor& one : leave_out()) erase(part, one);
    rename_part(part, placement_);
    set_parameters(part);
    Node points = take_points(part);
    if (placement_.fixed)
      fix_ground(part, std::move(points));
    else if (!points.items.empty())
      merge(carrier_points(), points);
    for (std::size_t i = 0; i < part.items.size(); ++i) merge_section(part.keys[i], part.items[i]);
  }

 private:
  const Place& place() const { return at_.node().place; }

  /// What a key says for this copy, if anything.
  std::optional<Cursor> said(const std::optional<Cursor>& value) const {
    if (!value) return std::nullopt;
    if (!value->is_map() || find_entry(value->node(), "free") != nullptr) return value;
    std::vector<std::string> names;
    for (const Cursor& one : entry_.names) names.push_back(one.node().text);
    std::optional<Cursor> own;
    for (const Member& member : members(*value, "a value, or one for each copy {name: value}")) {
      if (std::find(names.begin(), names.end(), member.name) == names.end())
        member.key.fail({.expected = fmt::format("one of the copies ({})", one_of(names)),
                         .found = in_quotes(member.name),
                         .hint = nearest_is(member.name, names)});
      if (member.name == placement_.name) own = member.value;
    }
    return own;
  }

  std::vector<Cursor> leave_out() const {
    if (!entry_.without) return {};
    return entry_.without->is_list() ? entry_.without->items("a list of names") : std::vector{*entry_.without};
  }

  /// `payloads`, `payloads.cargo`, `actuators.B`.
  static void erase(Node& part, const Cursor& what) {
    const std::string& text = what.word("a section of the part, or section.name");
    const std::string section = text.substr(0, text.find('.'));
    const auto fail = [&](const std::vector<std::string>& names) {
      what.fail({.expected = fmt::format("something that the part has ({})", names.empty() ? "nothing" : one_of(names)),
                 .found = in_quotes(text),
                 .hint = nearest_is(text, names)});
    };
    Node* node = find_entry(part, section);
    if (node == nullptr) fail(names_of_entries(&part));
    Node& holder = section == text ? part : *node;
    const std::string name = section == text ? text : text.substr(section.size() + 1);
    std::vector<std::string> names;
    for (std::size_t i = 0; i < holder.items.size(); ++i) {
      const bool map = holder.kind == Node::Kind::map;
      names.push_back((section == text ? "" : section + ".") + (map ? holder.keys[i].text : holder.items[i].text));
      if (names.back() != (section == text ? name : text)) continue;
      const auto place = static_cast<std::ptrdiff_t>(i);
      if (map) holder.keys.erase(holder.keys.begin() + place);
      holder.items.erase(holder.items.begin() + place);
      return;
    }
    fail(names);
  }

  void set_parameters(Node& part) const {
    if (!entry_.set) return;
    Node* parameters = find_entry(part, "parameters");
    const std::string begin = placement_.name + ".";
    for (const Member& member : members(*entry_.set, "parameters of the part {name: value}")) {
      Node* value = parameters == nullptr ? nullptr : find_entry(*parameters, begin + member.name);
      if (value == nullptr) {
        std::vector<std::string> names = names_of_entries(parameters);
        for (std::string& name : names) name.erase(0, begin.size());
        member.key.fail(
            {.expected = fmt::format("a parameter of the part ({})", names.empty() ? "there are none" : one_of(names)),
             .found = in_quotes(member.name),
             .hint = nearest_is(member.name, names)});
      }
      const auto own = said(member.value);
      if (!own) continue;
      const bool shared = own->is_scalar() && own->node().text == "shared";
      if (!shared) *value = own->node();
      if (shared && placement_.name != first_) *value = scalar_node(first_ + "." + member.name, own->node().place);
    }
  }

  /// Of the part's ground, which is no section any more.
  static Node take_points(Node& part) {
    for (std::size_t i = 0; i < part.items.size(); ++i) {
      if (part.keys[i].text != "ground") continue;
      Node points = map_node(part.items[i].place);
      if (Node* said = find_entry(part.items[i], "points")) points = std::move(*said);
      part.keys.erase(part.keys.begin() + static_cast<std::ptrdiff_t>(i));
      part.items.erase(part.items.begin() + static_cast<std::ptrdiff_t>(i));
      return points;
    }
    return map_node(part.place);
  }

  Node& carrier_points() {
    if (placement_.carrier == "ground") return map_at(map_at(document_, "ground", place()), "points", place());
    Node* bodies = find_entry(document_, "bodies");
    Node* carrier = bodies == nullptr ? nullptr : find_entry(*bodies, placement_.carrier);
    if (carrier != nullptr && carrier->kind == Node::Kind::map) return map_at(*carrier, "points", place());
    std::vector<std::string> names = names_of_entries(bodies);
    names.insert(names.begin(), "ground");
    (said(entry_.on) ? *said(entry_.on) : at_)
        .fail({.expected = fmt::format("a body that stands above the part ({})", one_of(names)),
               .found = in_quotes(placement_.carrier),
               .hint = nearest_is(placement_.carrier, names)});
  }

  /// The part's ground as a body without mass that is fixed to its carrier.
  void fix_ground(Node& part, Node points) {
    const Node zero = list_node(std::vector<std::string>(placement_.planar ? 2 : 3, "0"), place());
    const auto where = said(entry_.at);
    Node stand = map_node(place());
    add_entry(stand, scalar_node(placement_.name, place()), where ? where->node() : zero);
    merge(carrier_points(), stand);
    const std::string body = placement_.name + ".ground";
    // Its frame is where the part's ground has its origin, whatever the part calls `origin`.
    const bool own_origin = find_entry(points, "origin") != nullptr;
    if (own_origin) add_entry(points, scalar_node("frame." + placement_.name, place()), zero);
    Node ground = map_node(place());
    add_entry(ground, scalar_node("mass", place()), scalar_node("0", place()));
    add_entry(ground, scalar_node("points", place()), std::move(points));
    add_entry(map_at(part, "bodies", place()), scalar_node(body, place()), std::move(ground));
    Node joint = map_node(place());
    add_entry(joint, scalar_node("type", place()), scalar_node("fixed", place()));
    add_entry(joint, scalar_node("connects", place()),
              list_node({placement_.carrier + "." + placement_.name,
                         body + (own_origin ? ".frame." + placement_.name : ".origin")},
                        place()));
    for (const auto& [key, value] :
         {std::pair{"angle", entry_.angle}, {"rpy", entry_.rpy}, {"quaternion", entry_.quaternion}})
      if (const auto own = said(value)) add_entry(joint, scalar_node(key, place()), own->node());
    add_entry(map_at(part, "joints", place()), scalar_node(body, place()), std::move(joint));
  }

  void merge_section(const Node& key, Node& section) {
    Node* own = find_entry(document_, key.text);
    if (own == nullptr) return add_entry(document_, key, std::move(section));
    if (own->kind != section.kind) {
      const Cursor at(*own, key.text, at_.problems());
      at.expected(section.kind == Node::Kind::list ? "a list, as the part has it" : "a mapping, as the part has it");
    }
    if (section.kind == Node::Kind::list)
      own->items.insert(own->items.end(), section.items.begin(), section.items.end());
    else
      merge(*own, section, key.text == "assembly");
  }

  /// @param weak the document's own entries stay
  void merge(Node& into, Node& from, bool weak = false) const {
    if (into.kind != Node::Kind::map) Cursor(into, "", at_.problems()).expected("a mapping");
    for (std::size_t i = 0; i < from.items.size(); ++i) {
      if (find_entry(into, from.keys[i].text) == nullptr)
        add_entry(into, std::move(from.keys[i]), std::move(from.items[i]));
      else if (!weak)
        at_.fail({.expected = "a name that makes all names of the part new",
                  .found = fmt::format("{}, and {} twice", in_quotes(placement_.name), in_quotes(from.keys[i].text))});
    }
  }

  const PartEntry& entry_;
  const Cursor& at_;
  const std::string first_;
  Node& document_;
  Placement placement_;
};

}  // namespace

void read_copy_names(PartEntry& entry, const Node& document, std::vector<std::string>& taken) {
  const Cursor& as = *entry.as;
  entry.names = as.is_list() ? as.items("names of the copies") : std::vector{as};
  if (entry.names.empty()) as.expected("at least one name");
  const std::vector<std::string> bodies = names_of_entries(find_entry(document, "bodies"));
  for (const Cursor& one : entry.names) {
    const std::string& name = one.word("the name of a copy");
    if (!is_name(name)) one.fail({.expected = "a name of letters, digits, '_' and '-'", .found = in_quotes(name)});
    const bool again = std::find(taken.begin(), taken.end(), name) != taken.end();
    const bool body = name == "ground" || std::find(bodies.begin(), bodies.end(), name) != bodies.end();
    if (again || body || name == "free")
      one.fail({.expected = "a name of its own",
                .found = in_quotes(name) + (again  ? ", another copy's"
                                            : body ? ", a body's"
                                                   : ", which has a meaning")});
    taken.push_back(name);
  }
}

void place_copy(const PartEntry& entry, Node part, std::size_t index, Node& document) {
  Copy(entry, index, document).put(std::move(part));
}

}  // namespace balance::read
