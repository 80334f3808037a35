#include "balance/spec/cursor.hpp"

#include "balance/base/nearest.hpp"
#include "balance/base/plain_text.hpp"
#include "balance/spec/decimal_comma.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <unordered_set>
#include <utility>

namespace balance::read {

void Cursor::expected(const std::string& what) const { fail({.expected = what, .found = found()}); }

void Cursor::fail(Complaint complaint) const { throw Problem(node_->place, path_, std::move(complaint)); }

void Cursor::fail_unless_doubtful(const std::string& path, Complaint complaint) const {
  if (problems_->doubtful(path)) throw Consequence();
  fail(std::move(complaint));
}

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

void Cursor::missing(const std::vector<std::string>& keys) const {
  std::vector<std::string> wanted, given;
  for (const std::string& key : keys) wanted.push_back(in_quotes(key));
  for (const Node& one : node_->keys) given.push_back(one.text);
  Problem problem(node_->place, path_,
                  {.kind = "missing key",
                   .expected = one_of(wanted),
                   .found = given.empty() ? found() : "only " + listed(given, "and")});
  problem.about = path_.empty() ? keys.front() : path_ + "." + keys.front();
  throw Problem(std::move(problem));
}

std::vector<Cursor> Cursor::items(const std::string& what) const {
  if (!is_list()) expected(what);
  std::vector<Cursor> all;
  for (std::size_t i = 0; i < node_->items.size(); ++i)
    all.emplace_back(node_->items[i], fmt::format("{}[{}]", path_, i), *problems_);
  return all;
}

std::vector<Cursor> Cursor::items(const std::string& what, std::size_t count) const {
  if (is_list() && node_->items.size() > count)
    fail({.expected = what, .found = found(), .hint = decimal_comma_in(*node_)});
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
  found.fail({.expected = fmt::format("{} ({})", what, names.empty() ? "there are none" : one_of(names)),
              .found = found.found(),
              .hint = found.is_scalar() ? nearest_is(found.node().text, names) : ""});
}

namespace {

Cursor member_at(const Cursor& map, std::size_t i, const Node& node) {
  const std::string& name = map.node().keys[i].text;
  return {node, map.path().empty() ? name : map.path() + "." + name, map.problems()};
}

}  // namespace

std::vector<Member> members(const Cursor& map, const std::string& what) {
  if (!map.is_map()) map.expected(what);
  const Node& node = map.node();
  if (node.items.size() > most_members)
    map.fail(
        {.expected = fmt::format("at most {} entries", most_members), .found = fmt::format("{}", node.items.size())});
  std::vector<Member> all;
  std::unordered_set<std::string_view> seen;
  for (std::size_t i = 0; i < node.items.size(); ++i) {
    if (!seen.insert(node.keys[i].text).second) continue;  // already reported while parsing
    all.push_back({member_at(map, i, node.keys[i]), node.keys[i].text, member_at(map, i, node.items[i])});
  }
  return all;
}

namespace {

/// One name or several, joined by points: `leg1.crank`.
bool is_joined_name(std::string_view text) {
  for (std::size_t dot = text.find('.'); dot != std::string_view::npos; dot = text.find('.')) {
    if (!is_name(text.substr(0, dot))) return false;
    text.remove_prefix(dot + 1);
  }
  return is_name(text);
}

}  // namespace

std::vector<Member> named_members(const Cursor& map, const std::string& what, Names names) {
  const auto good = [&](const std::string& name) {
    return names == Names::joined ? is_joined_name(name) : is_name(name);
  };
  std::vector<Member> all = members(map, what);
  for (const Member& member : all)
    map.problems().guard([&] {
      if (good(member.name)) return;
      const bool otherwise_right = !member.name.empty() && good("x" + member.name);
      const std::string comma = decimal_comma_before(map.node(), member.name);
      Problem problem(member.key.node().place, member.key.path(),
                      {.expected = "a name of letters, digits, '_' and '-'",
                       .found = in_quotes(member.name),
                       .hint = !comma.empty()    ? comma
                               : otherwise_right ? "it must begin with a letter"
                                                 : ""});
      problem.odd_in = map.path();
      throw Problem(std::move(problem));
    });
  return all;
}

namespace {

/// Why nobody wrote what stands there.
std::string hint_for(const Node& map, const std::string& key, const std::vector<std::string>& names) {
  if (std::string comma = decimal_comma_before(map, key); !comma.empty()) return comma;
  const bool carried = std::find(names.begin(), names.end(), "body") != names.end();
  if (carried && (key == "true" || key == "True"))
    return "'on' is a truth value in YAML 1.1, so that a tool such as PyYAML writes 'true' for it: say 'body'";
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  if (!key.empty() && std::all_of(key.begin(), key.end(), is_digit))
    return "decimals stand behind a point; a comma separates entries";
  return nearest_is(key, names);
}

class FieldsReader {
 public:
  FieldsReader(const Cursor& map, const std::string& what, const std::vector<Field>& fields)
      : map_(map), fields_(fields), given_(members(map, what)) {
    for (const Field& field : fields) names_.push_back(field.name);
  }

  void read() {
    for (const Member& member : given_)
      if (!map_.problems().guard([&] { read_member(member); })) map_.problems().spoil(member.value.path());
    // A misspelt key is one mistake, not two.
    for (const Field& field : fields_)
      if (field.need == Need::required && !unknown_ && count(field) == 0)
        map_.problems().guard([&] { map_.missing({field.name}); });
  }

 private:
  static bool names(const Field& field, const std::string& key) {
    return key == field.name || (key == field.other && !key.empty());
  }

  std::ptrdiff_t count(const Field& field) const {
    return std::count_if(given_.begin(), given_.end(), [&](const Member& m) { return names(field, m.name); });
  }

  void read_member(const Member& member) {
    const auto field =
        std::find_if(fields_.begin(), fields_.end(), [&](const Field& f) { return names(f, member.name); });
    if (field == fields_.end()) fail_unknown(member);
    if (member.name == field->other && count(*field) > 1)
      member.key.fail({.expected = fmt::format("'{}' or '{}'", field->name, field->other), .found = "both"});
    field->read(member.value);
  }

  [[noreturn]] void fail_unknown(const Member& member) {
    unknown_ = true;
    Problem problem(member.key.node().place, member.key.path(),
                    {.kind = "unknown key",
                     .expected = one_of(names_),
                     .found = in_quotes(member.name),
                     .hint = hint_for(map_.node(), member.name, names_)});
    problem.odd_in = map_.path();
    throw Problem(std::move(problem));
  }

  const Cursor& map_;
  const std::vector<Field>& fields_;
  std::vector<Member> given_;
  std::vector<std::string> names_;
  bool unknown_ = false;
};

}  // namespace

bool read_fields(const Cursor& map, const std::string& what, const std::vector<Field>& fields) {
  return map.problems().guard([&] { FieldsReader(map, what, fields).read(); });
}

}  // namespace balance::read
