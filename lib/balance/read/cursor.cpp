#include "balance/read/cursor.hpp"

#include "balance/read/nearest.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace balance::read {

void Cursor::expected(const std::string& what) const { fail(fmt::format("expected {}, found {}", what, found())); }

void Cursor::fail(const std::string& text) const { throw Problem(node_->place, path_, text); }

std::string Cursor::found() const {
  switch (kind()) {
    case Node::Kind::null: return "nothing";
    case Node::Kind::scalar: return node_->text.empty() ? "an empty text" : in_quotes(node_->text);
    case Node::Kind::list:
      return node_->items.empty() ? "an empty list" : fmt::format("a list of {}", node_->items.size());
    case Node::Kind::map: return node_->items.empty() ? "an empty mapping" : "a mapping";
  }
  return "";
}

void Cursor::missing(const std::string& key) const {
  std::vector<std::string> keys;
  for (const Node& one : node_->keys) keys.push_back(one.text);
  fail(fmt::format("missing key: expected {}, found {}", key, keys.empty() ? found() : "only " + listed(keys, "and")));
}

std::vector<Cursor> Cursor::items(const std::string& what) const {
  if (!is_list()) expected(what);
  std::vector<Cursor> all;
  for (std::size_t i = 0; i < node_->items.size(); ++i)
    all.emplace_back(node_->items[i], fmt::format("{}[{}]", path_, i), *problems_);
  return all;
}

std::vector<Cursor> Cursor::items(const std::string& what, std::size_t count) const {
  if (!is_list() || node_->items.size() != count) expected(what);
  return items(what);
}

const std::string& Cursor::word(const std::string& what) const {
  if (!is_scalar() || node_->text.empty()) expected(what);
  return node_->text;
}

std::size_t Cursor::choice(const std::string& what, const std::vector<std::string>& names) const {
  const std::string& text = word(fmt::format("{} ({})", what, one_of(names)));
  const auto at = std::find(names.begin(), names.end(), text);
  if (at == names.end()) expected_one_of(*this, what, names);
  return static_cast<std::size_t>(at - names.begin());
}

void expected_one_of(const Cursor& found, const std::string& what, const std::vector<std::string>& names) {
  found.fail(fmt::format("expected {} ({}), found {}{}", what, names.empty() ? "there are none" : one_of(names),
                         found.found(), found.is_scalar() ? nearest_hint(found.node().text, names) : ""));
}

namespace {

Cursor member_at(const Cursor& map, std::size_t i, const Node& node) {
  const std::string& name = map.node().keys[i].text;
  return {node, map.path().empty() ? name : map.path() + "." + name, map.problems()};
}

/// Names are joined with dots to references and become names in result files.
bool fit_for_reference(const std::string& name) {
  return !name.empty() && name.find_first_of(" \t\r\n.,:;/\\[](){}'\"#&*!|>%@`=") == std::string::npos;
}

}  // namespace

std::vector<Member> members(const Cursor& map, const std::string& what) {
  if (!map.is_map()) map.expected(what);
  const Node& node = map.node();
  if (node.items.size() > most_members)
    map.fail(fmt::format("expected at most {} entries, found {}", most_members, node.items.size()));
  std::vector<Member> all;
  for (std::size_t i = 0; i < node.items.size(); ++i) {
    const bool again =
        std::any_of(all.begin(), all.end(), [&](const Member& m) { return m.name == node.keys[i].text; });
    if (again) continue;  // already reported while parsing
    all.push_back({member_at(map, i, node.keys[i]), node.keys[i].text, member_at(map, i, node.items[i])});
  }
  return all;
}

std::vector<Member> named_members(const Cursor& map, const std::string& what) {
  std::vector<Member> all = members(map, what);
  std::erase_if(all, [&](const Member& member) {
    return !map.problems().guard([&] {
      if (!fit_for_reference(member.name))
        member.key.fail(
            fmt::format("expected a name of letters, digits, '_' and '-', found {}", in_quotes(member.name)));
    });
  });
  return all;
}

bool read_fields(const Cursor& map, const std::string& what, const std::vector<Field>& fields) {
  std::vector<std::string> names;
  for (const Field& field : fields) names.push_back(field.name);
  return map.problems().guard([&] {
    const std::vector<Member> given = members(map, what);
    bool unknown = false;
    for (const Member& member : given) {
      const auto field =
          std::find_if(fields.begin(), fields.end(), [&](const Field& f) { return f.name == member.name; });
      map.problems().guard([&] {
        if (field != fields.end()) return field->read(member.value);
        unknown = true;
        member.key.fail(fmt::format("unknown key: expected {}, found {}{}", one_of(names), in_quotes(member.name),
                                    nearest_hint(member.name, names)));
      });
    }
    for (const Field& field : fields) {
      const bool there = std::any_of(given.begin(), given.end(), [&](const Member& m) { return m.name == field.name; });
      // A misspelt key is one mistake, not two.
      if (field.need == Need::required && !there && !unknown) map.missing(in_quotes(field.name));
    }
  });
}

}  // namespace balance::read
