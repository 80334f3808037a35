#include "balance/read/suite_case.hpp"

#include "balance/base/nearest.hpp"
#include "balance/base/plain_text.hpp"
#include "balance/motion/timing_bounds.hpp"
#include "balance/spec/flow_text.hpp"
#include "balance/spec/goals.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

namespace balance::read {

namespace {

constexpr std::size_t longest_name = 150;  // a file's name may have 255 bytes, and endings are put behind it

/// The value as YAML on one line.
std::string flow(const Node& node) {
  std::string text;
  switch (node.kind) {
    case Node::Kind::null: return "null";
    case Node::Kind::scalar: return as_scalar(node.text);
    case Node::Kind::list:
      for (const Node& item : node.items) text += (text.empty() ? "" : ", ") + flow(item);
      return "[" + text + "]";
    case Node::Kind::map:
      for (std::size_t i = 0; i < node.items.size(); ++i)
        text += (text.empty() ? "" : ", ") + as_scalar(node.keys[i].text) + ": " + flow(node.items[i]);
      return "{" + text + "}";
  }
  return text;
}

std::uint64_t read_seed(const Cursor& at) {
  const std::string what = "a seed, a whole number ≥ 0";
  const std::string& text = at.word(what);
  std::uint64_t seed = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), seed);
  if (error != std::errc() || end != text.data() + text.size()) at.expected(what);
  return seed;
}

std::optional<CaseDesign> read_case_design(const Cursor& at) {
  CaseDesign design;
  if (!at.is_map()) {
    const std::size_t choice =
        at.choice("whether to design first, or how {goal, strategy, minimize, seed}", {"true", "false"});
    return choice == 0 ? std::optional(design) : std::nullopt;
  }
  read_fields(at, "a design {goal, strategy, minimize, seed}",
              {{"goal", Need::optional, [&](const Cursor& c) { design.goals = read_goals(c); }},
               {"strategy", Need::optional,
                [&](const Cursor& c) {
                  design.modular = c.choice("a strategy", {"complete", "modular"}) == 1;
                }},
               {"minimize", Need::optional,
                [&](const Cursor& c) {
                  if (c.kind() == Node::Kind::null) c.expected("what to minimize");
                  design.minimize = flow(c.node());
                }},
               {"seed", Need::optional, [&](const Cursor& c) { design.seed = read_seed(c); }}});
  return design;
}

void read_set(const Cursor& at, SuiteDraft& draft, SuiteCase& one) {
  for (const Member& member : named_members(at, "parameters {name: value}")) {
    draft.problems.guard([&] {
      const std::string value = read_value(member.value);
      std::erase_if(one.set, [&](const auto& pair) { return pair.first == member.name; });
      one.set.emplace_back(member.name, value);
      note_place(one, "set." + member.name, draft.place(member.value));
    });
  }
}

/// As a name in a spec, but for a few more characters and what stands first.
bool fit_for_file(const std::string& name) {
  if (name.empty() || name.size() > longest_name || !begins_name(name[0])) return false;
  std::string as_name = "x" + name;
  for (char& c : as_name)
    if (std::string_view(".+=,").find(c) != std::string_view::npos) c = '_';
  return is_name(as_name);
}

}  // namespace

bool begins_name(char c) { return std::string_view("-.+=,").find(c) == std::string_view::npos; }

SpecPlace SuiteDraft::place(const Cursor& at) const {
  return {file, at.node().place.line, at.node().place.column, at.path()};
}

void note_place(SuiteCase& one, const std::string& part, const SpecPlace& place) {
  std::erase_if(one.places, [&](const auto& pair) { return pair.first == part; });
  one.places.emplace_back(part, place);
}

long read_samples(const Cursor& at) {
  const std::string what = fmt::format("a whole number from {} to {}", min_samples, max_samples);
  const std::string& text = at.word(what);
  long samples = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), samples);
  if (error != std::errc() || end != text.data() + text.size() || !is_sample_count(samples)) at.expected(what);
  return samples;
}

std::string read_value(const Cursor& at) { return at.word("a parameter's value, a number or an expression"); }

std::vector<Field> case_fields(SuiteDraft& draft, SuiteCase& one) {
  const auto noting = [&draft, &one](const std::string& part, auto read) {
    return Field{part, Need::optional, [&draft, &one, part, read](const Cursor& c) {
                   read(c);
                   note_place(one, part, draft.place(c));
                 }};
  };
  return {noting("spec", [&one](const Cursor& c) { one.spec = c.word("the name of a spec file"); }),
          noting("set", [&draft, &one](const Cursor& c) { read_set(c, draft, one); }),
          noting("trajectory", [&one](const Cursor& c) { one.trajectory = c.word("a trajectory's name"); }),
          noting("controller", [&one](const Cursor& c) { one.controller = c.word("a controller's name"); }),
          noting("samples", [&one](const Cursor& c) { one.samples = read_samples(c); }),
          noting("design", [&one](const Cursor& c) { one.design = read_case_design(c); })};
}

void add_case(SuiteDraft& draft, SuiteCase one, const Cursor& named) {
  if (!fit_for_file(one.name))
    named.fail({.expected = fmt::format(
                    "a name fit for a file (letters, digits and _ - . + = , at most {} of them, a letter, a "
                    "digit or '_' first)",
                    longest_name),
                .found = in_quotes(one.name)});
  if (draft.names.count(one.name) > 0)
    named.fail({.expected = "a name of its own for every case", .found = fmt::format("{} again", in_quotes(one.name))});
  if (one.spec.empty())
    named.fail(
        {.kind = "missing key", .expected = fmt::format("'spec' in case {} or in 'defaults'", in_quotes(one.name))});
  if (draft.cases.size() >= most_cases)
    named.fail({.expected = fmt::format("at most {} cases", most_cases), .found = "more"});
  note_place(one, "", draft.place(named));
  draft.names.insert(one.name);
  draft.cases.push_back(std::move(one));
}

}  // namespace balance::read

namespace balance {

SpecPlace SuiteCase::place_of(const std::string& part) const {
  for (const std::string& wanted : {part, std::string()}) {
    const auto at = std::find_if(places.begin(), places.end(), [&](const auto& pair) { return pair.first == wanted; });
    if (at != places.end()) return at->second;
  }
  return {.key = name};
}

}  // namespace balance
