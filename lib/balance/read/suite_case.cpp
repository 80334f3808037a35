#include "balance/read/suite_case.hpp"

#include "balance/base/nearest.hpp"
#include "balance/base/plain_text.hpp"
#include "balance/motion/timing_bounds.hpp"
#include "balance/spec/flow_text.hpp"
#include "balance/spec/goals.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

namespace balance::specification {

namespace {

constexpr std::size_t max_case_name_length = 150;  // a file's name may have 255 bytes, and endings are put behind it

/// The value as YAML on one line.
std::string format_flow_yaml(const YamlNode& node) {
  std::string text;
  switch (node.kind) {
    case YamlNode::Kind::null: return "null";
    case YamlNode::Kind::scalar: return format_scalar(node.text);
    case YamlNode::Kind::list:
      for (const YamlNode& item : node.items) text += (text.empty() ? "" : ", ") + format_flow_yaml(item);
      return "[" + text + "]";
    case YamlNode::Kind::map:
      for (std::size_t i = 0; i < node.items.size(); ++i)
        text += (text.empty() ? "" : ", ") + format_scalar(node.keys[i].text) + ": " + format_flow_yaml(node.items[i]);
      return "{" + text + "}";
  }
  return text;
}

std::uint64_t read_seed(const SpecCursor& at) {
  const std::string what = "a seed, a whole number ≥ 0";
  const std::string& text = at.read_word(what);
  std::uint64_t seed = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), seed);
  if (error != std::errc() || end != text.data() + text.size()) at.fail_expected(what);
  return seed;
}

std::optional<CaseDesignOptions> read_case_design(const SpecCursor& at) {
  CaseDesignOptions design;
  if (!at.is_map()) {
    const std::size_t choice =
        at.read_choice("whether to design first, or how {goal, strategy, minimize, seed}", {"true", "false"});
    return choice == 0 ? std::optional(design) : std::nullopt;
  }
  read_fields(at, "a design {goal, strategy, minimize, seed}",
              {{"goal", Presence::optional, [&](const SpecCursor& c) { design.goals = read_goals(c); }},
               {"strategy", Presence::optional,
                [&](const SpecCursor& c) {
                  design.modular = c.read_choice("a strategy", {"complete", "modular"}) == 1;
                }},
               {"minimize", Presence::optional,
                [&](const SpecCursor& c) {
                  if (c.kind() == YamlNode::Kind::null) c.fail_expected("what to minimize");
                  design.minimize = format_flow_yaml(c.node());
                }},
               {"seed", Presence::optional, [&](const SpecCursor& c) { design.seed = read_seed(c); }}});
  return design;
}

void read_set(const SpecCursor& at, SuiteBuilder& draft, SuiteCase& one) {
  for (const Member& member : list_named_members(at, "parameters {name: value}")) {
    draft.problems.collect([&] {
      const std::string value = read_value(member.value);
      std::erase_if(one.overrides, [&](const auto& pair) { return pair.first == member.name; });
      one.overrides.emplace_back(member.name, value);
      record_location(one, "set." + member.name, draft.place(member.value));
    });
  }
}

/// As a name in a spec, but for a few more characters and what stands first.
bool is_case_name(const std::string& name) {
  if (name.empty() || name.size() > max_case_name_length || !is_case_name_start(name[0])) return false;
  std::string as_name = "x" + name;
  for (char& c : as_name)
    if (std::string_view(".+=,").find(c) != std::string_view::npos) c = '_';
  return is_unicode_identifier(as_name);
}

}  // namespace

bool is_case_name_start(char c) { return std::string_view("-.+=,").find(c) == std::string_view::npos; }

SourceLocation SuiteBuilder::place(const SpecCursor& at) const {
  return {file, at.node().place.line, at.node().place.column, at.path()};
}

void record_location(SuiteCase& one, const std::string& part, const SourceLocation& place) {
  std::erase_if(one.locations, [&](const auto& pair) { return pair.first == part; });
  one.locations.emplace_back(part, place);
}

long read_samples(const SpecCursor& at) {
  const std::string what = fmt::format("a whole number from {} to {}", min_samples, max_samples);
  const std::string& text = at.read_word(what);
  long samples = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), samples);
  if (error != std::errc() || end != text.data() + text.size() || !is_valid_sample_count(samples))
    at.fail_expected(what);
  return samples;
}

std::string read_value(const SpecCursor& at) { return at.read_word("a parameter's value, a number or an expression"); }

std::vector<Field> make_case_fields(SuiteBuilder& draft, SuiteCase& one) {
  const auto noting = [&draft, &one](const std::string& part, auto read) {
    return Field{part, Presence::optional, [&draft, &one, part, read](const SpecCursor& c) {
                   read(c);
                   record_location(one, part, draft.place(c));
                 }};
  };
  return {noting("spec", [&one](const SpecCursor& c) { one.spec = c.read_word("the name of a spec file"); }),
          noting("set", [&draft, &one](const SpecCursor& c) { read_set(c, draft, one); }),
          noting("trajectory", [&one](const SpecCursor& c) { one.trajectory = c.read_word("a trajectory's name"); }),
          noting("controller", [&one](const SpecCursor& c) { one.controller = c.read_word("a controller's name"); }),
          noting("samples", [&one](const SpecCursor& c) { one.samples = read_samples(c); }),
          noting("design", [&one](const SpecCursor& c) { one.design = read_case_design(c); })};
}

void add_case(SuiteBuilder& draft, SuiteCase one, const SpecCursor& named) {
  if (!is_case_name(one.name))
    named.fail({.expected = fmt::format(
                    "a name fit for a file (letters, digits and _ - . + = , at most {} of them, a letter, a "
                    "digit or '_' first)",
                    max_case_name_length),
                .found = quote_for_message(one.name)});
  if (draft.names.count(one.name) > 0)
    named.fail({.expected = "a name of its own for every case",
                .found = fmt::format("{} again", quote_for_message(one.name))});
  if (one.spec.empty())
    named.fail({.kind = "missing key",
                .expected = fmt::format("'spec' in case {} or in 'defaults'", quote_for_message(one.name))});
  if (draft.cases.size() >= max_cases)
    named.fail({.expected = fmt::format("at most {} cases", max_cases), .found = "more"});
  record_location(one, "", draft.place(named));
  draft.names.insert(one.name);
  draft.cases.push_back(std::move(one));
}

}  // namespace balance::specification

namespace balance {

SourceLocation SuiteCase::location_of(const std::string& part) const {
  for (const std::string& wanted : {part, std::string()}) {
    const auto at =
        std::find_if(locations.begin(), locations.end(), [&](const auto& pair) { return pair.first == wanted; });
    if (at != locations.end()) return at->second;
  }
  return {.key = name};
}

}  // namespace balance
