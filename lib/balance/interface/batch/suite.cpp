#include "balance/interface/batch/suite.hpp"

#include "balance/foundation/base/error.hpp"
#include "balance/foundation/base/spelling.hpp"
#include "balance/foundation/base/unicode_text.hpp"
#include "balance/interface/specification/read_design.hpp"
#include "balance/interface/specification/spec_cursor.hpp"
#include "balance/interface/specification/text_file.hpp"
#include "balance/interface/specification/yaml_document.hpp"
#include "balance/mechanics/trajectory/trajectory.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <set>
#include <string>
#include <vector>

namespace balance::specification {

// One case of a suite, and what a matrix makes of several values.

/// A suite while it is read.
struct SuiteBuilder {
  explicit SuiteBuilder(const std::string& file_name) : file(file_name), problems(file_name) {}

  std::string file;
  SpecErrorCollector problems;
  SuiteCase defaults;
  std::vector<SuiteCase> cases;
  std::set<std::string> names;                  ///< of the cases
  std::vector<std::string> invalid_case_names;  ///< of cases with mistakes
  bool has_unnamed_cases = false;               ///< there are cases with mistakes whose names are not known
  std::vector<std::pair<std::size_t, SpecCursor>>
      requirements;  ///< of cases, by their index; read when all names are known

  /// "suite.yaml:4:7: cases.a.spec"
  SourceLocation place(const SpecCursor& at) const;
};

/// What `cases` and `defaults` share: spec, set, trajectory, controller, samples, design.
std::vector<Field> make_case_fields(SuiteBuilder& draft, SuiteCase& one);

/// Where a part of the case is said, from now on.
void record_location(SuiteCase& one, const std::string& part, const SourceLocation& place);

/// A number of samples.
long read_samples(const SpecCursor& at);

/// A parameter's value: a number or an expression.
std::string read_value(const SpecCursor& at);

/// Whether a name of a case may begin so: neither hidden, nor like an option, nor like a formula.
bool is_case_name_start(char c);

/// Adds a case. Fails at `named` if its name is taken or cannot be a file's.
void add_case(SuiteBuilder& draft, SuiteCase one, const SpecCursor& named);

/// `matrix`: one mapping of lists, or a list of such.
void read_matrices(const SpecCursor& section, SuiteBuilder& draft);

}  // namespace balance::specification

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

namespace balance::specification {

// Every spec with every trajectory with every value of each parameter.

namespace {

/// One value of one axis, its part of the cases' names, and where it stands.
struct AxisValue {
  std::string name, value;
  SourceLocation place;
};

/// What varies, and what a choice of it does to a case.
struct MatrixAxis {
  std::vector<AxisValue> choices;
  std::function<void(const AxisValue&, SuiteCase&)> apply;
};

double read_plain(const SpecCursor& at) {
  const std::string& text = at.read_word("a number");
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) at.fail_expected("a number");
  return value;
}

/// What a file's name cannot hold becomes `_`.
std::string sanitise_for_file_name(std::string text) {
  for (char& c : text)
    if (!std::isalnum(static_cast<unsigned char>(c)) && std::string_view("_-.+").find(c) == std::string_view::npos)
      c = '_';
  return text;
}

/// One or several words, each a choice.
std::vector<AxisValue> read_words(const SpecCursor& at, const std::string& what,
                                  const std::function<AxisValue(const SpecCursor&)>& read) {
  if (!at.is_list()) return {read(at)};
  std::vector<AxisValue> choices;
  for (const SpecCursor& item : at.items(what)) at.problems().collect([&] { choices.push_back(read(item)); });
  if (at.node().items.empty()) at.fail_expected("at least one of " + what);
  return choices;
}

[[noreturn]] void throw_too_many_cases(const SpecCursor& at) {
  at.fail({.expected = fmt::format("at most {} cases", max_cases), .found = "more"});
}

/// `{from: 0, to: 1, count: 5}`: evenly spaced, both ends included. @param most how many values may be
std::vector<AxisValue> read_range(const SpecCursor& at, const std::string& name, std::size_t most,
                                  const SuiteBuilder& draft) {
  double from = 0, to = 0;
  long count = 0;
  const bool read = read_fields(at, "values {from, to, count}",
                                {{"from", Presence::required, [&](const SpecCursor& c) { from = read_plain(c); }},
                                 {"to", Presence::required, [&](const SpecCursor& c) { to = read_plain(c); }},
                                 {"count", Presence::required, [&](const SpecCursor& c) { count = read_samples(c); }}});
  std::vector<AxisValue> choices;
  if (!read) return choices;
  if (static_cast<std::size_t>(count) > most) throw_too_many_cases(at);
  const SourceLocation place = draft.place(at);
  for (long i = 0; i < count; ++i) {
    const double part = static_cast<double>(i) / static_cast<double>(count - 1);
    const std::string value = fmt::format("{}", i + 1 == count ? to : from + (to - from) * part);
    choices.push_back({name + "=" + sanitise_for_file_name(value), value, place});
  }
  return choices;
}

MatrixAxis read_parameter(const Member& member, std::size_t most, const SuiteBuilder& draft) {
  const std::string& name = member.name;
  MatrixAxis axis;
  axis.apply = [name](const AxisValue& choice, SuiteCase& one) {
    std::erase_if(one.overrides, [&](const auto& pair) { return pair.first == name; });
    one.overrides.emplace_back(name, choice.value);
    record_location(one, "set." + name, choice.place);
  };
  axis.choices = member.value.is_map() ? read_range(member.value, name, most, draft)
                                       : read_words(member.value, "values", [&](const SpecCursor& c) -> AxisValue {
                                           const std::string value = read_value(c);
                                           return {name + "=" + sanitise_for_file_name(value), value, draft.place(c)};
                                         });
  return axis;
}

struct MatrixAxes {
  std::string prefix;
  MatrixAxis specs, trajectories, controllers;
  std::vector<MatrixAxis> parameters;
};

MatrixAxis read_specs(const SpecCursor& at, const SuiteBuilder& draft) {
  const auto read = [&](const SpecCursor& c) -> AxisValue {
    const std::string file = c.read_word("the name of a spec file");
    return {sanitise_for_file_name(std::filesystem::path(file).stem().string()), file, draft.place(c)};
  };
  return {read_words(at, "spec files", read), [](const AxisValue& choice, SuiteCase& one) {
            one.spec = choice.value;
            record_location(one, "spec", choice.place);
          }};
}

/// Names of things in the specs. @param of whose
MatrixAxis read_names(const SpecCursor& at, const std::string& key, std::string SuiteCase::*of,
                      const SuiteBuilder& draft) {
  const auto read = [&](const SpecCursor& c) -> AxisValue {
    const std::string name = c.read_word("a " + key + "'s name");
    return {sanitise_for_file_name(name), name, draft.place(c)};
  };
  return {read_words(at, key == "trajectory" ? "trajectories" : key + "s", read),
          [key, of](const AxisValue& choice, SuiteCase& one) {
            one.*of = choice.value;
            record_location(one, key, choice.place);
          }};
}

/// A file's name may begin as a case's may not.
std::string sanitise_name_start(std::string name) {
  if (!name.empty() && !is_case_name_start(name[0])) name[0] = '_';
  return name;
}

/// Counts through the axes, the last of them fastest.
void expand_matrix(const std::vector<MatrixAxis>& axes, const std::string& prefix, const SuiteCase& base,
                   const SpecCursor& at, SuiteBuilder& draft) {
  std::size_t count = 1;
  for (const MatrixAxis& axis : axes) {
    count *= axis.choices.size();
    if (count + draft.cases.size() > max_cases) throw_too_many_cases(at);
  }
  for (std::size_t number = 0; number < count; ++number) {
    SuiteCase one = base;
    one.name = prefix;
    std::size_t block = count;
    std::size_t rest = number;
    for (const MatrixAxis& axis : axes) {
      block /= axis.choices.size();
      const AxisValue& choice = axis.choices[rest / block];
      rest %= block;
      one.name += one.name.empty() ? sanitise_name_start(choice.name) : "_" + choice.name;
      axis.apply(choice, one);
    }
    add_case(draft, std::move(one), at);
  }
}

void read_matrix(const SpecCursor& at, SuiteBuilder& draft) {
  SuiteCase base = draft.defaults;
  MatrixAxes axes;
  std::vector<Field> fields = {
      {"name", Presence::optional,
       [&](const SpecCursor& c) { axes.prefix = c.read_word("how the cases' names begin"); }},
      {"spec", Presence::optional, [&](const SpecCursor& c) { axes.specs = read_specs(c, draft); }},
      {"trajectory", Presence::optional,
       [&](const SpecCursor& c) { axes.trajectories = read_names(c, "trajectory", &SuiteCase::trajectory, draft); }},
      {"controller", Presence::optional,
       [&](const SpecCursor& c) { axes.controllers = read_names(c, "controller", &SuiteCase::controller, draft); }},
      {"set", Presence::optional, [&](const SpecCursor& c) {
         std::size_t most = max_cases;
         for (const Member& member : list_named_members(c, "parameters {name: [values]}"))
           draft.problems.collect([&] {
             axes.parameters.push_back(read_parameter(member, most, draft));
             most /= std::max<std::size_t>(1, axes.parameters.back().choices.size());
           });
       }}};
  for (Field& field : make_case_fields(draft, base))
    if (field.name == "samples" || field.name == "design") fields.push_back(std::move(field));
  if (!read_fields(at, "a matrix {name, spec, trajectory, controller, set, samples, design}", fields)) return;
  std::vector<MatrixAxis> all;
  for (const MatrixAxis* axis : {&axes.specs, &axes.trajectories, &axes.controllers})
    if (!axis->choices.empty()) all.push_back(*axis);
  all.insert(all.end(), axes.parameters.begin(), axes.parameters.end());
  if (all.empty())
    at.fail({.expected = "at least one of 'spec', 'trajectory', 'controller' and 'set'", .found = "none"});
  expand_matrix(all, axes.prefix, base, at, draft);
}

}  // namespace

void read_matrices(const SpecCursor& section, SuiteBuilder& draft) {
  if (!section.is_list()) return read_matrix(section, draft);
  for (const SpecCursor& item : section.items("a list of matrices"))
    draft.problems.collect([&] { read_matrix(item, draft); });
}

}  // namespace balance::specification
