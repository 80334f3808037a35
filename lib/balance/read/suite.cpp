#include "balance/read/suite.hpp"

#include "balance/base/error.hpp"
#include "balance/base/nearest.hpp"
#include "balance/base/plain_text.hpp"
#include "balance/read/suite_case.hpp"
#include "balance/spec/text_file.hpp"

#include <fmt/format.h>

#include <filesystem>

namespace balance {

namespace read {
namespace {

/// One case; `named` is its key, or the case itself in a list.
void read_case(const Cursor& at, const Cursor& named, const std::string& name, SuiteDraft& draft) {
  SuiteCase one = draft.defaults;
  one.name = name;
  std::optional<Cursor> name_given, require;
  std::vector<Field> fields = case_fields(draft, one);
  fields.push_back({"require", Need::optional, [&](const Cursor& c) { require = c; }});
  if (name.empty())
    fields.push_back({"name", Need::required, [&](const Cursor& c) {
                        one.name = c.word("the case's name");
                        name_given = c;
                      }});
  const bool added = read_fields(at, "a case {spec, set, trajectory, samples, design, require}", fields) &&
                     draft.problems.guard([&] { add_case(draft, one, name_given ? *name_given : named); });
  if (!added) {
    draft.lacks_names = draft.lacks_names || one.name.empty();
    draft.spoilt_names.push_back(one.name);
    return;
  }
  if (require) draft.requirements.emplace_back(draft.cases.size() - 1, *require);
}

void read_cases(const Cursor& section, SuiteDraft& draft) {
  if (section.is_list()) {
    for (const Cursor& item : section.items("a list of cases"))
      draft.problems.guard([&] { read_case(item, item, "", draft); });
    return;
  }
  for (const Member& member : members(section, "cases: a mapping from their names, or a list"))
    draft.problems.guard([&] { read_case(member.value, member.key, member.name, draft); });
}

/// One requirement, or a list of them.
std::vector<SuiteRequirement> read_requirements(const Cursor& at, const RunNames& names, SuiteDraft& draft) {
  std::vector<SuiteRequirement> all;
  const auto one = [&](const Cursor& c) {
    const std::string what = "a requirement such as 'peak(shaking_force) <= 0.9 * base'";
    const std::string& text = c.word(what);
    try {
      all.push_back({read_requirement(text, names), draft.place(c)});
    } catch (const RequirementError& wrong) {
      c.fail({.message = wrong.what(), .expected = what, .found = in_quotes(text), .hint = wrong.what()});
    }
  };
  if (!at.is_list()) {
    one(at);
    return all;
  }
  for (const Cursor& item : at.items("a list of requirements")) draft.problems.guard([&] { one(item); });
  return all;
}

/// The sections whose meaning depends on others, kept until those are read.
struct Later {
  std::optional<Cursor> cases, matrix, baseline, require;
};

void read_sections(const Cursor& root, Suite& suite, SuiteDraft& draft, Later& later) {
  if (!root.is_map()) root.expected("a suite: a mapping with 'cases' or 'matrix'");
  const auto keep = [](std::optional<Cursor>& place) { return [&place](const Cursor& c) { place = c; }; };
  read_fields(root, "a suite {name, defaults, cases, matrix, baseline, require}",
              {{"name", Need::optional, [&](const Cursor& c) { suite.name = visible(c.word("a name")); }},
               {"defaults", Need::optional,
                [&](const Cursor& c) {
                  read_fields(c, "what all cases share {spec, set, trajectory, samples, design}",
                              case_fields(draft, draft.defaults));
                }},
               {"cases", Need::optional, keep(later.cases)},
               {"matrix", Need::optional, keep(later.matrix)},
               {"baseline", Need::optional, keep(later.baseline)},
               {"require", Need::optional, keep(later.require)}});
}

/// What refers to cases by their names.
void read_references(const Later& later, Suite& suite, SuiteDraft& draft) {
  RunNames names;
  for (const SuiteCase& one : draft.cases) names.all.push_back(one.name);
  names.all.insert(names.all.end(), draft.spoilt_names.begin(), draft.spoilt_names.end());
  if (draft.lacks_names) return;  // else they would be missed
  if (later.baseline && !draft.problems.guard([&] {
        suite.baseline = names.all[later.baseline->choice("the name of a case", names.all)];
      }))
    suite.baseline = names.all.front();  // else requirements would complain about a base that is there
  names.base = suite.baseline;
  if (later.require) draft.problems.guard([&] { suite.require = read_requirements(*later.require, names, draft); });
  for (const auto& [index, at] : draft.requirements)
    draft.problems.guard(
        [&, &index = index, &at = at] { draft.cases[index].require = read_requirements(at, names, draft); });
}

}  // namespace
}  // namespace read

Suite read_suite(const std::string& text, const std::string& file_name) {
  using namespace read;
  SuiteDraft draft(file_name);
  Suite suite;
  suite.file = file_name;
  suite.name = std::filesystem::path(file_name).stem().string();
  Node root;
  Later later;
  try {
    if (text.find_first_not_of(" \t\r\n") == std::string::npos)
      throw Problem({1, 1}, "", {.expected = "a suite", .found = "an empty file"});
    root = parse_yaml(text, draft.problems);
    read_sections(Cursor(root, "", draft.problems), suite, draft, later);
    if (later.cases) draft.problems.guard([&] { read_cases(*later.cases, draft); });
    if (later.matrix && !draft.problems.guard([&] { read_matrices(*later.matrix, draft); })) draft.lacks_names = true;
    const bool named = !draft.cases.empty() || !draft.spoilt_names.empty();
    if (!named) draft.problems.throw_all();
    if (!named)
      Cursor(root, "", draft.problems).fail({.expected = "at least one case in 'cases' or 'matrix'", .found = "none"});
    read_references(later, suite, draft);
  } catch (const Problem& problem) {
    draft.problems.add(problem);
  }
  draft.problems.throw_all();
  suite.cases = std::move(draft.cases);
  return suite;
}

Suite read_suite_file(const std::string& path) { return read_suite(read_text_file(path, "suite"), shown_name(path)); }

}  // namespace balance
