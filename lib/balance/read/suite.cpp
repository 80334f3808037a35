#include "balance/read/suite.hpp"

#include "balance/base/error.hpp"
#include "balance/base/nearest.hpp"
#include "balance/base/plain_text.hpp"
#include "balance/read/suite_case.hpp"
#include "balance/spec/text_file.hpp"

#include <fmt/format.h>

#include <filesystem>

namespace balance {

namespace specification {
namespace {

/// One case; `named` is its key, or the case itself in a list.
void read_case(const SpecCursor& at, const SpecCursor& named, const std::string& name, SuiteBuilder& draft) {
  SuiteCase one = draft.defaults;
  one.name = name;
  std::optional<SpecCursor> name_given, require;
  std::vector<Field> fields = make_case_fields(draft, one);
  fields.push_back({"require", Presence::optional, [&](const SpecCursor& c) { require = c; }});
  if (name.empty())
    fields.push_back({"name", Presence::required, [&](const SpecCursor& c) {
                        one.name = c.read_word("the case's name");
                        name_given = c;
                      }});
  const bool added = read_fields(at, "a case {spec, set, trajectory, samples, design, require}", fields) &&
                     draft.problems.collect([&] { add_case(draft, one, name_given ? *name_given : named); });
  if (!added) {
    draft.has_unnamed_cases = draft.has_unnamed_cases || one.name.empty();
    draft.invalid_case_names.push_back(one.name);
    return;
  }
  if (require) draft.requirements.emplace_back(draft.cases.size() - 1, *require);
}

void read_cases(const SpecCursor& section, SuiteBuilder& draft) {
  if (section.is_list()) {
    for (const SpecCursor& item : section.items("a list of cases"))
      draft.problems.collect([&] { read_case(item, item, "", draft); });
    return;
  }
  for (const Member& member : list_members(section, "cases: a mapping from their names, or a list"))
    draft.problems.collect([&] { read_case(member.value, member.key, member.name, draft); });
}

/// One requirement, or a list of them.
std::vector<SuiteRequirement> read_requirements(const SpecCursor& at, const RunNames& names, SuiteBuilder& draft) {
  std::vector<SuiteRequirement> all;
  const auto one = [&](const SpecCursor& c) {
    const std::string what = "a requirement such as 'peak(shaking_force) <= 0.9 * base'";
    const std::string& text = c.read_word(what);
    try {
      all.push_back({parse_requirement(text, names), draft.place(c)});
    } catch (const RequirementError& wrong) {
      c.fail({.message = wrong.what(), .expected = what, .found = quote_for_message(text), .hint = wrong.what()});
    }
  };
  if (!at.is_list()) {
    one(at);
    return all;
  }
  for (const SpecCursor& item : at.items("a list of requirements")) draft.problems.collect([&] { one(item); });
  return all;
}

/// The sections whose meaning depends on others, kept until those are read.
struct DeferredSections {
  std::optional<SpecCursor> cases, matrix, baseline, require;
};

void read_sections(const SpecCursor& root, Suite& suite, SuiteBuilder& draft, DeferredSections& later) {
  if (!root.is_map()) root.fail_expected("a suite: a mapping with 'cases' or 'matrix'");
  const auto keep = [](std::optional<SpecCursor>& place) { return [&place](const SpecCursor& c) { place = c; }; };
  read_fields(root, "a suite {name, defaults, cases, matrix, baseline, require}",
              {{"name", Presence::optional,
                [&](const SpecCursor& c) { suite.name = escape_for_terminal(c.read_word("a name")); }},
               {"defaults", Presence::optional,
                [&](const SpecCursor& c) {
                  read_fields(c, "what all cases share {spec, set, trajectory, samples, design}",
                              make_case_fields(draft, draft.defaults));
                }},
               {"cases", Presence::optional, keep(later.cases)},
               {"matrix", Presence::optional, keep(later.matrix)},
               {"baseline", Presence::optional, keep(later.baseline)},
               {"require", Presence::optional, keep(later.require)}});
}

/// What refers to cases by their names.
void read_references(const DeferredSections& later, Suite& suite, SuiteBuilder& draft) {
  RunNames names;
  for (const SuiteCase& one : draft.cases) names.all.push_back(one.name);
  names.all.insert(names.all.end(), draft.invalid_case_names.begin(), draft.invalid_case_names.end());
  if (draft.has_unnamed_cases) return;  // else they would be missed
  if (later.baseline && !draft.problems.collect([&] {
        suite.baseline = names.all[later.baseline->read_choice("the name of a case", names.all)];
      }))
    suite.baseline = names.all.front();  // else requirements would complain about a base that is there
  names.base = suite.baseline;
  if (later.require) draft.problems.collect([&] { suite.require = read_requirements(*later.require, names, draft); });
  for (const auto& [index, at] : draft.requirements)
    draft.problems.collect(
        [&, &index = index, &at = at] { draft.cases[index].requirements = read_requirements(at, names, draft); });
}

}  // namespace
}  // namespace specification

Suite parse_suite(const std::string& text, const std::string& file_name) {
  using namespace specification;
  SuiteBuilder draft(file_name);
  Suite suite;
  suite.file = file_name;
  suite.name = std::filesystem::path(file_name).stem().string();
  YamlNode root;
  DeferredSections later;
  try {
    if (text.find_first_not_of(" \t\r\n") == std::string::npos)
      throw ReadError({1, 1}, "", {.expected = "a suite", .found = "an empty file"});
    root = parse_yaml(text, draft.problems);
    read_sections(SpecCursor(root, "", draft.problems), suite, draft, later);
    if (later.cases) draft.problems.collect([&] { read_cases(*later.cases, draft); });
    if (later.matrix && !draft.problems.collect([&] { read_matrices(*later.matrix, draft); }))
      draft.has_unnamed_cases = true;
    const bool named = !draft.cases.empty() || !draft.invalid_case_names.empty();
    if (!named) draft.problems.throw_if_any();
    if (!named)
      SpecCursor(root, "", draft.problems)
          .fail({.expected = "at least one case in 'cases' or 'matrix'", .found = "none"});
    read_references(later, suite, draft);
  } catch (const ReadError& problem) {
    draft.problems.add(problem);
  }
  draft.problems.throw_if_any();
  suite.cases = std::move(draft.cases);
  return suite;
}

Suite read_suite_file(const std::string& path) {
  return parse_suite(read_text_file(path, "suite"), display_name(path));
}

}  // namespace balance
