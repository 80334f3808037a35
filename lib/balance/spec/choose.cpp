#include "balance/spec/choose.hpp"

#include "balance/spec/source_text.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace balance::read {

namespace {

const std::vector<std::string> sections = {"counterweights", "discs", "springs"};

std::vector<std::string> names_in_section(const std::string& section, const Draft& draft) {
  std::vector<std::string> names;
  const MechanismOf<Expression>& mechanism = draft.mechanism();
  if (section == "discs")
    for (const auto& disc : mechanism.discs) names.push_back(disc.name);
  else if (section == "springs")
    for (const auto& spring : mechanism.springs) names.push_back(spring.name);
  else
    for (const auto& one : mechanism.attachments)
      if (one.kind == AttachmentKind::counterweight) names.push_back(one.name);
  return names;
}

/// A designed spec: what was free is a number now, and what was left out is not there.
bool has_free_numbers(const Draft& draft) {
  return !draft.free_numbers.empty() || !draft.parameters.free_numbers().empty();
}

int read_most(const Cursor& at, Draft& draft, long offered) {
  if (at.is_scalar() && at.node().text == "least") return -1;
  const std::string what = fmt::format("how many are kept at most, 0 to {}, or least", offered);
  if (!at.is_scalar()) at.expected(what);
  const double value = draft.parameters.evaluate(at).value();
  const long most = has_free_numbers(draft) ? offered : static_cast<long>(most_members);
  if (value != static_cast<double>(static_cast<long>(value)) || value < 0 || value > static_cast<double>(most))
    at.expected(what);
  return static_cast<int>(value);
}

void read_from(const Cursor& at, const Draft& draft, ElementChoice& choice) {
  const std::vector<std::string> known = names_in_section(choice.section, draft);
  choice.from.clear();
  choice.all = false;
  read_each(at.items("names of " + choice.section), [&](const Cursor& item) {
    const std::string& name = item.word("a name");
    if (!has_free_numbers(draft)) return;
    if (std::find(known.begin(), known.end(), name) == known.end()) {
      if (!draft.mechanism_is_right) throw Consequence();
      expected_one_of(item, "one of the " + choice.section, known);
    }
    for (const OfferedElement& other : choice.from)
      if (other.name == name) item.fail({.expected = "every name once", .found = item.found() + " again"});
    choice.from.push_back({name});
  });
  if (at.node().items.empty()) at.expected("at least one name");
}

ElementChoice read_choice(const std::string& section, const Cursor& at, Draft& draft) {
  ElementChoice choice{section, {}, true, -1};
  for (const std::string& name : names_in_section(section, draft)) choice.from.push_back({name});
  if (has_free_numbers(draft) && draft.mechanism_is_right && choice.from.empty())
    at.fail({.expected = section + " to choose among", .found = "none in the spec"});
  if (!at.is_map()) {
    choice.most = read_most(at, draft, static_cast<long>(choice.from.size()));
    return choice;
  }
  std::optional<Cursor> most;
  const bool right = read_fields(at, "a number, least or {from: names, most: …}",
                                 {{"from", Need::optional, [&](const Cursor& c) { read_from(c, draft, choice); }},
                                  {"most", Need::optional, [&](const Cursor& c) { most = c; }}});
  if (!right) throw Consequence();
  if (most) choice.most = read_most(*most, draft, static_cast<long>(choice.from.size()));
  return choice;
}

/// Finds in the document what an entry takes up.
class EntryText {
 public:
  explicit EntryText(const std::string& text) : source_(text) {}

  /// Empty where the entry cannot be taken out: others repeat what is in it.
  Span of(const Node& map, std::size_t which) const {
    const Node &key = map.keys[which], &value = map.items[which];
    if (map.alias != 0 || bears_anchor(value)) return {};
    const std::size_t begin = source_.span(key).begin;
    const std::size_t end = std::max(source_.span(key).end, source_.span(value).end);
    return map.flow ? between_commas(map, which, begin, end) : whole_lines(begin, end);
  }

 private:
  static bool bears_anchor(const Node& node) {
    return node.anchor != 0 || std::any_of(node.items.begin(), node.items.end(), bears_anchor);
  }

  /// With the comma behind it, or the last one with that before it.
  Span between_commas(const Node& map, std::size_t which, std::size_t begin, std::size_t end) const {
    if (which + 1 < map.keys.size()) return {begin, source_.span(map.keys[which + 1]).begin};
    const std::size_t after = source_.skip_blank(end);
    if (after < source_.text().size() && source_.text()[after] == ',') end = after + 1;
    return {begin, end};
  }

  Span whole_lines(std::size_t begin, std::size_t end) const {
    begin -= source_.indentation(begin).size();
    if (begin > 0 && !source_.is_break(begin - 1)) return {};
    end = source_.line_end(end);
    if (source_.text().compare(end, 2, "\r\n") == 0) return {begin, end + 2};
    return {begin, std::min(end + 1, source_.text().size())};
  }

  SourceText source_;
};

const Node* find_section(const Node& root, const std::string& name) {
  for (std::size_t i = 0; i < root.keys.size(); ++i)
    if (root.keys[i].text == name) return &root.items[i];
  return nullptr;
}

}  // namespace

std::vector<ElementChoice> read_choices(const Cursor& at, Draft& draft) {
  std::vector<ElementChoice> choices;
  std::vector<Field> fields;
  for (const std::string& section : sections)
    fields.push_back({section, Need::optional, [&choices, &draft, section](const Cursor& c) {
                        choices.push_back(read_choice(section, c, draft));
                      }});
  if (!read_fields(at, "what to choose among {counterweights, discs, springs}", fields)) throw Consequence();
  if (choices.empty()) at.missing(sections);
  return choices;
}

void list_offered_texts(const Node& root, Study& study) {
  const EntryText entries(study.spec_text);
  for (ElementChoice& choice : study.design.choose) {
    const Node* section = find_section(root, choice.section);
    if (section == nullptr) continue;
    for (std::size_t i = 0; i < section->keys.size(); ++i) {
      const std::string& name = section->keys[i].text;
      const auto known = std::find_if(choice.from.begin(), choice.from.end(),
                                      [&](const OfferedElement& one) { return one.name == name; });
      if (known == choice.from.end()) continue;
      const Span span = entries.of(*section, i);
      known->begin = span.begin;
      known->end = span.end;
    }
  }
}

}  // namespace balance::read
