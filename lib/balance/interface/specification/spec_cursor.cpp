#include "balance/interface/specification/spec_cursor.hpp"

#include "balance/foundation/base/spelling.hpp"
#include "balance/foundation/base/unicode_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <unordered_set>
#include <utility>

namespace balance::specification {
namespace {

/// A decimal comma makes two entries of a number: `0,25` in brackets or braces.
/// @return what to write, if the second follows the first without a space; else empty
std::string find_decimal_comma_between(const YamlNode& first, const YamlNode& second) {
  const auto ends_in_digit = [](const std::string& text) {
    return !text.empty() && text.back() >= '0' && text.back() <= '9';
  };
  const bool adjacent = first.kind == YamlNode::Kind::scalar && second.kind == YamlNode::Kind::scalar &&
                        !first.is_quoted && !second.is_quoted && first.place.line == second.place.line &&
                        second.place.column == first.place.column + static_cast<int>(first.text.size()) + 1;
  if (!adjacent || !ends_in_digit(first.text)) return "";
  return suggest_decimal_point(first.text + "," + second.text);
}

}  // namespace

std::string find_decimal_comma_in(const YamlNode& list) {
  for (std::size_t i = 0; i + 1 < list.items.size(); ++i)
    if (std::string hint = find_decimal_comma_between(list.items[i], list.items[i + 1]); !hint.empty())
      return "if the comma is a decimal sign: " + hint;
  return "";
}

std::string find_decimal_comma_before(const YamlNode& map, const std::string& key) {
  for (std::size_t i = 1; i < map.keys.size(); ++i)
    if (map.keys[i].text == key && map.items[i].kind == YamlNode::Kind::null)
      return find_decimal_comma_between(map.items[i - 1], map.keys[i]);
  return "";
}

bool SpecCursor::has_entry(const std::string& key) const {
  const std::vector<YamlNode>& keys = node_->keys;
  return std::any_of(keys.begin(), keys.end(), [&](const YamlNode& one) { return one.text == key; });
}

void SpecCursor::fail_expected(const std::string& what) const { fail({.expected = what, .found = describe_found()}); }

void SpecCursor::fail(ErrorMessage error_message) const {
  throw ReadError(node_->place, path_, std::move(error_message));
}

void SpecCursor::fail_unless_uncertain(const std::string& path, ErrorMessage error_message) const {
  if (problems_->is_uncertain(path)) throw CascadingError();
  fail(std::move(error_message));
}

std::string SpecCursor::describe_found() const {
  switch (kind()) {
    case YamlNode::Kind::null: return "nothing";
    case YamlNode::Kind::scalar: return node_->text.empty() ? "an empty text" : quote_for_message(node_->text);
    case YamlNode::Kind::list:
      return node_->items.empty() ? "an empty list" : fmt::format("a list of {}", node_->items.size());
    case YamlNode::Kind::map: return node_->items.empty() ? "an empty mapping" : "a mapping";
  }
  return "";
}

void SpecCursor::fail_missing(const std::vector<std::string>& keys) const {
  std::vector<std::string> expected_keys, given_keys;
  for (const std::string& key : keys) expected_keys.push_back(quote_for_message(key));
  for (const YamlNode& key : node_->keys) given_keys.push_back(key.text);
  ReadError error(
      node_->place, path_,
      {.kind = "missing key",
       .expected = join_alternatives(expected_keys),
       .found = given_keys.empty() ? describe_found() : "only " + join_with_conjunction(given_keys, "and")});
  error.subject_path = path_.empty() ? keys.front() : path_ + "." + keys.front();
  throw ReadError(std::move(error));
}

std::vector<SpecCursor> SpecCursor::items(const std::string& what) const {
  if (!is_list()) fail_expected(what);
  std::vector<SpecCursor> cursors;
  for (std::size_t i = 0; i < node_->items.size(); ++i)
    cursors.emplace_back(node_->items[i], fmt::format("{}[{}]", path_, i), *problems_);
  return cursors;
}

std::vector<SpecCursor> SpecCursor::items(const std::string& what, std::size_t count) const {
  if (is_list() && node_->items.size() > count)
    fail({.expected = what, .found = describe_found(), .hint = find_decimal_comma_in(*node_)});
  if (!is_list() || node_->items.size() != count) fail_expected(what);
  return items(what);
}

const std::string& SpecCursor::read_word(const std::string& what) const {
  if (!is_scalar() || node_->text.empty()) fail_expected(what);
  return node_->text;
}

std::size_t SpecCursor::read_choice(const std::string& what, const std::vector<std::string>& names) const {
  const std::string& text = read_word(fmt::format("{} ({})", what, join_alternatives(names)));
  const auto match = std::find(names.begin(), names.end(), text);
  if (match == names.end()) fail_expected_one_of(*this, what, names);
  return static_cast<std::size_t>(match - names.begin());
}

void fail_expected_one_of(const SpecCursor& cursor, const std::string& what, const std::vector<std::string>& names) {
  cursor.fail({.expected = fmt::format("{} ({})", what, names.empty() ? "there are none" : join_alternatives(names)),
               .found = cursor.describe_found(),
               .hint = cursor.is_scalar() ? format_nearest_name(cursor.node().text, names) : ""});
}

namespace {

SpecCursor member_at(const SpecCursor& map, std::size_t i, const YamlNode& node) {
  const std::string& name = map.node().keys[i].text;
  return {node, map.path().empty() ? name : map.path() + "." + name, map.problems()};
}

}  // namespace

std::vector<Member> list_members(const SpecCursor& map, const std::string& what) {
  if (!map.is_map()) map.fail_expected(what);
  const YamlNode& node = map.node();
  if (node.items.size() > max_members)
    map.fail(
        {.expected = fmt::format("at most {} entries", max_members), .found = fmt::format("{}", node.items.size())});
  std::vector<Member> members;
  std::unordered_set<std::string_view> names;
  for (std::size_t i = 0; i < node.items.size(); ++i) {
    if (!names.insert(node.keys[i].text).second) continue;  // already reported while parsing
    members.push_back({member_at(map, i, node.keys[i]), node.keys[i].text, member_at(map, i, node.items[i])});
  }
  return members;
}

namespace {

/// One name, or several joined by dots: `leg1.crank`.
bool is_dotted_name(std::string_view text) {
  for (std::size_t dot = text.find('.'); dot != std::string_view::npos; dot = text.find('.')) {
    if (!is_unicode_identifier(text.substr(0, dot))) return false;
    text.remove_prefix(dot + 1);
  }
  return is_unicode_identifier(text);
}

}  // namespace

std::vector<Member> list_named_members(const SpecCursor& map, const std::string& what, NameForm names) {
  const auto is_valid_name = [&](const std::string& name) {
    return names == NameForm::dotted ? is_dotted_name(name) : is_unicode_identifier(name);
  };
  std::vector<Member> members = list_members(map, what);
  for (const Member& member : members)
    map.problems().collect([&] {
      if (is_valid_name(member.name)) return;
      const bool lacks_first_letter = !member.name.empty() && is_valid_name("x" + member.name);
      const std::string comma = find_decimal_comma_before(map.node(), member.name);
      ReadError error(member.key.node().place, member.key.path(),
                      {.expected = "a name of letters, digits, '_' and '-'",
                       .found = quote_for_message(member.name),
                       .hint = !comma.empty()       ? comma
                               : lacks_first_letter ? "it must begin with a letter"
                                                    : ""});
      error.unknown_key_in = map.path();
      throw ReadError(std::move(error));
    });
  return members;
}

namespace {

/// Likely cause of an unknown key.
std::string unknown_key_hint(const YamlNode& map, const std::string& key, const std::vector<std::string>& names) {
  if (std::string comma = find_decimal_comma_before(map, key); !comma.empty()) return comma;
  const bool has_body_key = std::find(names.begin(), names.end(), "body") != names.end();
  if (has_body_key && (key == "true" || key == "True"))
    return "'on' is a truth value in YAML 1.1, and tools such as PyYAML write 'true' for it: use 'body'";
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  if (!key.empty() && std::all_of(key.begin(), key.end(), is_digit))
    return "use a decimal point; a comma separates entries";
  return format_nearest_name(key, names);
}

class FieldsReader {
 public:
  FieldsReader(const SpecCursor& map, const std::string& what, const std::vector<Field>& fields)
      : map_(map), fields_(fields), members_(list_members(map, what)) {
    for (const Field& field : fields) names_.push_back(field.name);
  }

  void read() {
    for (const Member& member : members_)
      if (!map_.problems().collect([&] { read_member(member); })) map_.problems().mark_invalid(member.value.path());
    // A misspelt key is one mistake, not two.
    for (const Field& field : fields_)
      if (field.need == Presence::required && !unknown_ && count(field) == 0)
        map_.problems().collect([&] { map_.fail_missing({field.name}); });
  }

 private:
  static bool is_named(const Field& field, const std::string& key) {
    return key == field.name || (key == field.alias && !key.empty());
  }

  std::ptrdiff_t count(const Field& field) const {
    return std::count_if(members_.begin(), members_.end(), [&](const Member& m) { return is_named(field, m.name); });
  }

  void read_member(const Member& member) {
    const auto field =
        std::find_if(fields_.begin(), fields_.end(), [&](const Field& f) { return is_named(f, member.name); });
    if (field == fields_.end()) fail_unknown(member);
    if (member.name == field->alias && count(*field) > 1)
      member.key.fail({.expected = fmt::format("'{}' or '{}'", field->name, field->alias), .found = "both"});
    field->read(member.value);
  }

  [[noreturn]] void fail_unknown(const Member& member) {
    unknown_ = true;
    ReadError error(member.key.node().place, member.key.path(),
                    {.kind = "unknown key",
                     .expected = join_alternatives(names_),
                     .found = quote_for_message(member.name),
                     .hint = unknown_key_hint(map_.node(), member.name, names_)});
    error.unknown_key_in = map_.path();
    throw ReadError(std::move(error));
  }

  const SpecCursor& map_;
  const std::vector<Field>& fields_;
  std::vector<Member> members_;
  std::vector<std::string> names_;
  bool unknown_ = false;
};

}  // namespace

bool read_fields(const SpecCursor& map, const std::string& what, const std::vector<Field>& fields) {
  return map.problems().collect([&] { FieldsReader(map, what, fields).read(); });
}

void read_entry_per_name(const SpecCursor& at, const std::vector<std::string>& names, Presence need,
                         const std::string& expected_list, const std::string& expected_mapping,
                         const std::function<void(const SpecCursor& at, std::size_t name)>& read_entry) {
  if (at.is_list()) {
    std::size_t next = 0;
    read_each(at.items(expected_list, names.size()), [&](const SpecCursor& item) { read_entry(item, next++); });
  } else if (at.is_map()) {
    std::vector<Field> fields;
    for (std::size_t i = 0; i < names.size(); ++i)
      fields.push_back({names[i], need, [&read_entry, i](const SpecCursor& entry) { read_entry(entry, i); }});
    if (!read_fields(at, expected_mapping, fields)) throw CascadingError();
  } else {
    for (std::size_t i = 0; i < names.size(); ++i) read_entry(at, i);
  }
}

}  // namespace balance::specification
