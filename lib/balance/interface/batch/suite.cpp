#include "balance/interface/batch/suite.hpp"

#include "balance/foundation/base/error.hpp"
#include "balance/foundation/base/spelling.hpp"
#include "balance/foundation/base/unicode_text.hpp"
#include "balance/interface/batch/case_settings.hpp"
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
#include <map>
#include <set>
#include <string>
#include <vector>

namespace balance::batch {

using comparison::FigureReference;
using specification::Presence;
using specification::SpecCursor;

// Reading one case of a suite, and expanding a matrix of several values.

/// A suite while it is being read.
struct SuiteBuilder {
  explicit SuiteBuilder(const std::string& file_name) : file(file_name), problems(file_name) {}

  std::string file;
  specification::SpecErrorCollector problems;
  SuiteCase defaults;
  std::vector<SuiteCase> cases;
  std::set<std::string> names;                  ///< of the cases
  std::vector<std::string> invalid_case_names;  ///< of cases with mistakes
  bool has_unnamed_cases = false;               ///< some cases with mistakes have unknown names
  std::vector<std::pair<std::size_t, SpecCursor>> requirements,
      published;  ///< of cases, by their index; read when all names are known

  /// "suite.yaml:4:7: cases.a.spec"
  SourceLocation place(const SpecCursor& at) const;
};

/// Fields that `cases` and `defaults` share: spec, set, trajectory, controller, samples, design, run, …
std::vector<specification::Field> make_case_fields(SuiteBuilder& builder, SuiteCase& suite_case);

/// Records where a part of the case is given; replaces an earlier location.
void record_location(SuiteCase& suite_case, const std::string& key, const SourceLocation& place);

/// Reads a number of samples.
long read_samples(const SpecCursor& at);

/// Reads a parameter's value: a number or an expression.
std::string read_value(const SpecCursor& at);

/// Whether a case's name may start with this character: not like a hidden file, an option or a formula.
bool is_case_name_start(char c);

/// Adds a case. Fails at `named` if its name is taken or not valid in a file name.
void add_case(SuiteBuilder& builder, SuiteCase suite_case, const SpecCursor& named);

/// Reads `matrix`: one mapping of lists, or a list of such mappings.
void read_matrices(const SpecCursor& section, SuiteBuilder& builder);

namespace {

/// Reads one case; `named` is its key, or the case itself in a list.
void read_case(const SpecCursor& at, const SpecCursor& named, const std::string& name, SuiteBuilder& builder) {
  SuiteCase suite_case = builder.defaults;
  suite_case.name = name;
  std::optional<SpecCursor> name_cursor, require, published;
  std::vector<specification::Field> fields = make_case_fields(builder, suite_case);
  fields.push_back({"require", Presence::optional, [&](const SpecCursor& c) { require = c; }});
  fields.push_back({"published", Presence::optional, [&](const SpecCursor& c) { published = c; }});
  fields.push_back({"waits", Presence::optional, [&](const SpecCursor& c) {
                      read_each(c.items("a list of numbers without figures"), [&](const SpecCursor& item) {
                        suite_case.source.waits.push_back(read_waiting_row(item));
                      });
                    }});
  if (name.empty())
    fields.push_back({"name", Presence::required, [&](const SpecCursor& c) {
                        suite_case.name = c.read_word("the case's name");
                        name_cursor = c;
                      }});
  const bool added =
      read_fields(at, "a case {spec, set, trajectory, samples, design, run, require, published}", fields) &&
      builder.problems.collect([&] {
        check_case_keys(at, suite_case.kind);
        add_case(builder, suite_case, name_cursor ? *name_cursor : named);
      });
  if (!added) {
    builder.has_unnamed_cases = builder.has_unnamed_cases || suite_case.name.empty();
    builder.invalid_case_names.push_back(suite_case.name);
    return;
  }
  if (require) builder.requirements.emplace_back(builder.cases.size() - 1, *require);
  if (published) builder.published.emplace_back(builder.cases.size() - 1, *published);
}

void read_cases(const SpecCursor& section, SuiteBuilder& builder) {
  if (section.is_list()) {
    for (const SpecCursor& item : section.items("a list of cases"))
      builder.problems.collect([&] { read_case(item, item, "", builder); });
    return;
  }
  for (const specification::Member& member : list_members(section, "a list of cases, or a mapping from their names"))
    builder.problems.collect([&] { read_case(member.value, member.key, member.name, builder); });
}

/// Reads one requirement or a list of them.
std::vector<SuiteRequirement> read_requirements(const SpecCursor& at, const comparison::RunNames& names,
                                                SuiteBuilder& builder) {
  std::vector<SuiteRequirement> requirements;
  const auto read_one = [&](const SpecCursor& c) {
    requirements.push_back(
        {read_requirement(c, names, "a requirement such as 'peak(shaking_force) <= 0.9 * base'"), builder.place(c)});
  };
  if (!at.is_list()) {
    read_one(at);
    return requirements;
  }
  for (const SpecCursor& item : at.items("a list of requirements")) builder.problems.collect([&] { read_one(item); });
  return requirements;
}

/// Sections that depend on others; kept until those have been read.
struct DeferredSections {
  std::optional<SpecCursor> cases, matrix, baseline, require;
};

void read_sections(const SpecCursor& root, Suite& suite, SuiteBuilder& builder, DeferredSections& deferred) {
  if (!root.is_map()) root.fail_expected("a suite: a mapping with 'cases' or 'matrix'");
  const auto store_in = [](std::optional<SpecCursor>& slot) { return [&slot](const SpecCursor& c) { slot = c; }; };
  specification::read_fields(root, "a suite {name, defaults, cases, matrix, baseline, require}",
                             {{"name", Presence::optional,
                               [&](const SpecCursor& c) { suite.name = escape_for_terminal(c.read_word("a name")); }},
                              {"defaults", Presence::optional,
                               [&](const SpecCursor& c) {
                                 read_fields(c, "defaults of all cases {spec, set, trajectory, samples, design, run}",
                                             make_case_fields(builder, builder.defaults));
                               }},
                              {"cases", Presence::optional, store_in(deferred.cases)},
                              {"matrix", Presence::optional, store_in(deferred.matrix)},
                              {"baseline", Presence::optional, store_in(deferred.baseline)},
                              {"require", Presence::optional, store_in(deferred.require)}});
}

/// Reads the sections that refer to cases by name.
void read_references(const DeferredSections& deferred, Suite& suite, SuiteBuilder& builder) {
  comparison::RunNames names;
  for (const SuiteCase& suite_case : builder.cases) names.all.push_back(suite_case.name);
  names.all.insert(names.all.end(), builder.invalid_case_names.begin(), builder.invalid_case_names.end());
  if (builder.has_unnamed_cases) return;  // otherwise references to them would count as mistakes
  if (deferred.baseline && !builder.problems.collect([&] {
        suite.baseline = names.all[deferred.baseline->read_choice("the name of a case", names.all)];
      }))
    suite.baseline = names.all.front();  // otherwise requirements would report a missing base
  names.base = suite.baseline;
  const auto is_single_state = [](const SuiteCase& one) {
    return one.kind == CaseKind::equations || one.kind == CaseKind::modes;
  };
  if (deferred.require)
    builder.problems.collect([&] {
      names.accepts_bare_quantities = std::all_of(builder.cases.begin(), builder.cases.end(), is_single_state);
      suite.require = read_requirements(*deferred.require, names, builder);
    });
  const auto names_of = [&](const SuiteCase& suite_case) -> const comparison::RunNames& {
    names.accepts_bare_quantities = is_single_state(suite_case);
    return names;
  };
  for (const auto& [index, at] : builder.requirements) {
    SuiteCase& suite_case = builder.cases[index];
    builder.problems.collect(
        [&, &at = at] { suite_case.requirements = read_requirements(at, names_of(suite_case), builder); });
  }
  for (const auto& [index, at] : builder.published) {
    SuiteCase& suite_case = builder.cases[index];
    const bool has_proof = std::any_of(suite_case.requirements.begin(), suite_case.requirements.end(),
                                       [](const SuiteRequirement& one) { return refers_to_verdict(one.requirement); });
    builder.problems.collect([&, &at = at] {
      for (const SpecCursor& item : at.items("a list of published numbers"))
        builder.problems.collect([&] {
          PublishedRow row = read_published_row(item, names_of(suite_case), has_proof, builder.file);
          for (const PublishedRow& earlier : suite_case.published)
            if (earlier.what == row.what)
              item.fail({.message = fmt::format("two published numbers of one case are called {}",
                                                quote_for_message(row.what)),
                         .expected = "another name in 'what'",
                         .found = quote_for_message(row.what)});
          suite_case.published.push_back(std::move(row));
        });
    });
  }
}

}  // namespace

Suite parse_suite(const std::string& text, const std::string& file_name) {
  using namespace specification;
  SuiteBuilder builder(file_name);
  Suite suite;
  suite.file = file_name;
  suite.name = std::filesystem::path(file_name).stem().string();
  YamlNode root;
  DeferredSections deferred;
  try {
    if (text.find_first_not_of(" \t\r\n") == std::string::npos)
      throw ReadError({1, 1}, "", {.expected = "a suite", .found = "an empty file"});
    root = parse_yaml(text, builder.problems);
    read_sections(SpecCursor(root, "", builder.problems), suite, builder, deferred);
    if (deferred.cases) builder.problems.collect([&] { read_cases(*deferred.cases, builder); });
    if (deferred.matrix && !builder.problems.collect([&] { read_matrices(*deferred.matrix, builder); }))
      builder.has_unnamed_cases = true;
    const bool has_cases = !builder.cases.empty() || !builder.invalid_case_names.empty();
    if (!has_cases) builder.problems.throw_if_any();
    if (!has_cases)
      SpecCursor(root, "", builder.problems)
          .fail({.expected = "at least one case in 'cases' or 'matrix'", .found = "none"});
    read_references(deferred, suite, builder);
  } catch (const ReadError& problem) {
    builder.problems.add(problem);
  }
  builder.problems.throw_if_any();
  suite.cases = std::move(builder.cases);
  return suite;
}

namespace {

/// Visits the requirements of a case: its own, and those of the suite that are judged for it or name it.
/// @param visit called with a requirement and whether figures without a run belong to the case
template <class Visitor>
void for_each_requirement_of(const Suite& suite, const SuiteCase& suite_case, Visitor&& visit) {
  for (const SuiteRequirement& one : suite.require) visit(one.requirement, suite_case.name != suite.baseline);
  for (const SuiteRequirement& one : suite_case.requirements) visit(one.requirement, true);
  for (const PublishedRow& row : suite_case.published)
    if (row.proof) visit(row.proof->requirement, true);
}

void add_figure(std::vector<FigureReference>& figures, const FigureReference& figure) {
  const bool is_known = std::any_of(figures.begin(), figures.end(),
                                    [text = figure.text()](const auto& known) { return known.text() == text; });
  if (!is_known) figures.push_back(figure);
}

}  // namespace

std::vector<std::vector<FigureReference>> list_asked_figures(const Suite& suite) {
  std::vector<std::vector<FigureReference>> asked(suite.cases.size());
  std::map<std::string, std::size_t> index;
  for (std::size_t i = 0; i < suite.cases.size(); ++i) index[suite.cases[i].name] = i;
  const auto add = [&](const FigureReference& figure, std::optional<std::size_t> own_case) {
    if (!figure.run.empty())
      add_figure(asked[index.at(figure.run)], figure);
    else if (own_case)
      add_figure(asked[*own_case], figure);
  };
  for (const SuiteRequirement& one : suite.require)
    for (const FigureReference& figure : list_figures(one.requirement)) {
      if (!figure.run.empty()) add(figure, std::nullopt);
      for (std::size_t i = 0; figure.run.empty() && i < suite.cases.size(); ++i)
        if (suite.cases[i].name != suite.baseline) add(figure, i);
    }
  for (std::size_t i = 0; i < suite.cases.size(); ++i) {
    const SuiteCase& suite_case = suite.cases[i];
    for (const SuiteRequirement& one : suite_case.requirements)
      for (const FigureReference& figure : list_figures(one.requirement)) add(figure, i);
    for (const PublishedRow& row : suite_case.published) {
      for (const FigureReference& figure : row.figure.figures) add(figure, i);
      if (!row.proof) continue;
      for (const FigureReference& figure : list_figures(row.proof->requirement)) add(figure, i);
    }
  }
  return asked;
}

bool asks_for_verdict(const Suite& suite, const SuiteCase& suite_case) {
  bool asks = false;
  for_each_requirement_of(suite, suite_case, [&](const comparison::Requirement& requirement, bool is_own) {
    for (const comparison::RequirementComparison& comparison : requirement.comparisons)
      for (const FigureReference& figure : comparison.left.figures)
        asks = asks || (!comparison.word.empty() && (figure.run.empty() ? is_own : figure.run == suite_case.name));
  });
  return asks;
}

Suite read_suite_file(const std::string& path) {
  return parse_suite(specification::read_text_file(path, "suite"), specification::display_name(path));
}

namespace {

constexpr std::size_t max_case_name_length = 150;  // a file name may have 255 bytes, and suffixes are appended

/// The value as single-line YAML.
std::string format_flow_yaml(const specification::YamlNode& node) {
  std::string text;
  switch (node.kind) {
    case specification::YamlNode::Kind::null: return "null";
    case specification::YamlNode::Kind::scalar: return specification::format_scalar(node.text);
    case specification::YamlNode::Kind::list:
      for (const specification::YamlNode& item : node.items)
        text += (text.empty() ? "" : ", ") + format_flow_yaml(item);
      return "[" + text + "]";
    case specification::YamlNode::Kind::map:
      for (std::size_t i = 0; i < node.items.size(); ++i)
        text += (text.empty() ? "" : ", ") + specification::format_scalar(node.keys[i].text) + ": " +
                format_flow_yaml(node.items[i]);
      return "{" + text + "}";
  }
  return text;
}

std::uint64_t read_seed(const SpecCursor& at) {
  const std::string expectation = "a seed, a whole number ≥ 0";
  const std::string& text = at.read_word(expectation);
  std::uint64_t seed = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), seed);
  if (error != std::errc() || end != text.data() + text.size()) at.fail_expected(expectation);
  return seed;
}

std::optional<CaseDesignOptions> read_case_design(const SpecCursor& at) {
  CaseDesignOptions design;
  if (!at.is_map()) {
    const std::size_t choice =
        at.read_choice("a truth value or a design {goal, strategy, minimize, seed}", {"true", "false"});
    return choice == 0 ? std::optional(design) : std::nullopt;
  }
  specification::read_fields(at, "a design {goal, strategy, minimize, seed}",
                             {{"goal", Presence::optional, [&](const SpecCursor& c) { design.goals = read_goals(c); }},
                              {"strategy", Presence::optional,
                               [&](const SpecCursor& c) {
                                 design.modular = c.read_choice("a strategy", {"complete", "modular"}) == 1;
                               }},
                              {"minimize", Presence::optional,
                               [&](const SpecCursor& c) {
                                 if (c.kind() == specification::YamlNode::Kind::null)
                                   c.fail_expected("what to minimize");
                                 design.minimize = format_flow_yaml(c.node());
                               }},
                              {"seed", Presence::optional, [&](const SpecCursor& c) { design.seed = read_seed(c); }}});
  return design;
}

void read_set(const SpecCursor& at, SuiteBuilder& builder, SuiteCase& suite_case) {
  for (const specification::Member& member : list_named_members(at, "parameters {name: value}")) {
    builder.problems.collect([&] {
      const std::string value = read_value(member.value);
      std::erase_if(suite_case.overrides, [&](const auto& pair) { return pair.first == member.name; });
      suite_case.overrides.emplace_back(member.name, value);
      record_location(suite_case, "set." + member.name, builder.place(member.value));
    });
  }
}

/// Like a name in a spec, except for a few more characters and the first one.
bool is_case_name(const std::string& name) {
  if (name.empty() || name.size() > max_case_name_length || !is_case_name_start(name[0])) return false;
  std::string as_name = "x" + name;
  for (char& c : as_name)
    if (std::string_view(".+=,").find(c) != std::string_view::npos) c = '_';
  return is_unicode_identifier(as_name);
}

}  // namespace

bool is_case_name_start(char c) { return std::string_view("-.+=,").find(c) == std::string_view::npos; }

SourceLocation SuiteBuilder::place(const SpecCursor& at) const { return locate(at, file); }

void record_location(SuiteCase& suite_case, const std::string& key, const SourceLocation& place) {
  std::erase_if(suite_case.locations, [&](const auto& pair) { return pair.first == key; });
  suite_case.locations.emplace_back(key, place);
}

long read_samples(const SpecCursor& at) {
  const std::string expectation =
      fmt::format("a whole number from {} to {}", trajectory::min_samples, trajectory::max_samples);
  const std::string& text = at.read_word(expectation);
  long samples = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), samples);
  if (error != std::errc() || end != text.data() + text.size() || !trajectory::is_valid_sample_count(samples))
    at.fail_expected(expectation);
  return samples;
}

std::string read_value(const SpecCursor& at) { return at.read_word("a parameter's value, a number or an expression"); }

std::vector<specification::Field> make_case_fields(SuiteBuilder& builder, SuiteCase& suite_case) {
  const auto make_field = [&builder, &suite_case](const std::string& key, auto read) {
    return specification::Field{key, Presence::optional, [&builder, &suite_case, key, read](const SpecCursor& c) {
                                  read(c);
                                  record_location(suite_case, key, builder.place(c));
                                }};
  };
  return {
      make_field("spec",
                 [&suite_case](const SpecCursor& c) { suite_case.spec = c.read_word("the name of a spec file"); }),
      make_field("set", [&builder, &suite_case](const SpecCursor& c) { read_set(c, builder, suite_case); }),
      make_field("trajectory",
                 [&suite_case](const SpecCursor& c) { suite_case.trajectory = c.read_word("a trajectory's name"); }),
      make_field("controller",
                 [&suite_case](const SpecCursor& c) { suite_case.controller = c.read_word("a controller's name"); }),
      make_field("samples", [&suite_case](const SpecCursor& c) { suite_case.samples = read_samples(c); }),
      make_field("design", [&suite_case](const SpecCursor& c) { suite_case.design = read_case_design(c); }),
      make_field("run", [&suite_case](const SpecCursor& c) { suite_case.kind = read_case_kind(c); }),
      make_field("goal", [&suite_case](const SpecCursor& c) { suite_case.goals = read_goals(c); }),
      make_field("at", [&suite_case](const SpecCursor& c) { suite_case.state.at = read_state_pose(c); }),
      make_field("rates", [&suite_case](const SpecCursor& c) { suite_case.state.rates = read_state_rates(c); }),
      make_field("accelerations",
                 [&suite_case](const SpecCursor& c) { suite_case.state.accelerations = read_state_rates(c); }),
      make_field("sweep",
                 [&suite_case](const SpecCursor& c) { suite_case.sweep = c.read_word("a sweep such as v=1:10:91"); }),
      make_field("points",
                 [&builder, &suite_case](const SpecCursor& c) {
                   read_case_points(c, suite_case, [&](const std::string& key, const SpecCursor& at) {
                     record_location(suite_case, key, builder.place(at));
                   });
                 }),
      make_field("solve",
                 [&builder, &suite_case](const SpecCursor& c) {
                   read_solved_parameters(c, suite_case, [&](const std::string& key, const SpecCursor& at) {
                     record_location(suite_case, key, builder.place(at));
                   });
                 }),
      make_field("source", [&suite_case](const SpecCursor& c) { suite_case.source.source = c.read_word("a source"); }),
      make_field("page", [&suite_case](const SpecCursor& c) { suite_case.source.page = c.read_word("a page"); })};
}

void add_case(SuiteBuilder& builder, SuiteCase suite_case, const SpecCursor& named) {
  if (!is_case_name(suite_case.name))
    named.fail({.expected = fmt::format(
                    "a name usable as a file name (letters, digits and _ - . + = , at most {} of them, a letter, a "
                    "digit or '_' first)",
                    max_case_name_length),
                .found = quote_for_message(suite_case.name)});
  if (builder.names.count(suite_case.name) > 0)
    named.fail({.expected = "a unique name for each case",
                .found = fmt::format("{} again", quote_for_message(suite_case.name))});
  if (suite_case.spec.empty())
    named.fail({.kind = "missing key",
                .expected = fmt::format("'spec' in case {} or in 'defaults'", quote_for_message(suite_case.name))});
  if (builder.cases.size() >= max_cases)
    named.fail({.expected = fmt::format("at most {} cases", max_cases), .found = "more"});
  check_case(named, suite_case);
  record_location(suite_case, "", builder.place(named));
  builder.names.insert(suite_case.name);
  builder.cases.push_back(std::move(suite_case));
}

SourceLocation SuiteCase::location_of(const std::string& key) const {
  for (const std::string& candidate : {key, std::string()}) {
    const auto entry =
        std::find_if(locations.begin(), locations.end(), [&](const auto& pair) { return pair.first == candidate; });
    if (entry != locations.end()) return entry->second;
  }
  return {.key = name};
}

// All combinations of specs, trajectories, controllers and parameter values.

namespace {

/// One value of an axis, its part of the cases' names, and its location.
struct AxisValue {
  std::string name, value;
  SourceLocation place;
};

/// The values of an axis, and what a choice changes in a case.
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

/// Replaces characters that are not valid in a file name by `_`.
std::string sanitise_for_file_name(std::string text) {
  for (char& c : text)
    if (!std::isalnum(static_cast<unsigned char>(c)) && std::string_view("_-.+").find(c) == std::string_view::npos)
      c = '_';
  return text;
}

/// Reads one or several words, each a choice.
std::vector<AxisValue> read_words(const SpecCursor& at, const std::string& expectation,
                                  const std::function<AxisValue(const SpecCursor&)>& read) {
  if (!at.is_list()) return {read(at)};
  std::vector<AxisValue> choices;
  for (const SpecCursor& item : at.items(expectation)) at.problems().collect([&] { choices.push_back(read(item)); });
  if (at.node().items.empty()) at.fail_expected("at least one of " + expectation);
  return choices;
}

[[noreturn]] void throw_too_many_cases(const SpecCursor& at) {
  at.fail({.expected = fmt::format("at most {} cases", max_cases), .found = "more"});
}

/// `{from: 0, to: 1, count: 5}`: evenly spaced values, both ends included. @param max_values maximum number of values
std::vector<AxisValue> read_range(const SpecCursor& at, const std::string& name, std::size_t max_values,
                                  const SuiteBuilder& builder) {
  double from = 0, to = 0;
  long count = 0;
  const bool is_complete = specification::read_fields(
      at, "values {from, to, count}",
      {{"from", Presence::required, [&](const SpecCursor& c) { from = read_plain(c); }},
       {"to", Presence::required, [&](const SpecCursor& c) { to = read_plain(c); }},
       {"count", Presence::required, [&](const SpecCursor& c) { count = read_samples(c); }}});
  std::vector<AxisValue> choices;
  if (!is_complete) return choices;
  if (static_cast<std::size_t>(count) > max_values) throw_too_many_cases(at);
  const SourceLocation place = builder.place(at);
  for (long i = 0; i < count; ++i) {
    const double fraction = static_cast<double>(i) / static_cast<double>(count - 1);
    const std::string value = fmt::format("{}", i + 1 == count ? to : from + (to - from) * fraction);
    choices.push_back({name + "=" + sanitise_for_file_name(value), value, place});
  }
  return choices;
}

MatrixAxis read_parameter(const specification::Member& member, std::size_t max_values, const SuiteBuilder& builder) {
  const std::string& name = member.name;
  MatrixAxis axis;
  axis.apply = [name](const AxisValue& choice, SuiteCase& suite_case) {
    std::erase_if(suite_case.overrides, [&](const auto& pair) { return pair.first == name; });
    suite_case.overrides.emplace_back(name, choice.value);
    record_location(suite_case, "set." + name, choice.place);
  };
  axis.choices = member.value.is_map() ? read_range(member.value, name, max_values, builder)
                                       : read_words(member.value, "values", [&](const SpecCursor& c) -> AxisValue {
                                           const std::string value = read_value(c);
                                           return {name + "=" + sanitise_for_file_name(value), value, builder.place(c)};
                                         });
  return axis;
}

struct MatrixAxes {
  std::string prefix;
  MatrixAxis specs, trajectories, controllers;
  std::vector<MatrixAxis> parameters;
};

MatrixAxis read_specs(const SpecCursor& at, const SuiteBuilder& builder) {
  const auto read = [&](const SpecCursor& c) -> AxisValue {
    const std::string file = c.read_word("the name of a spec file");
    return {sanitise_for_file_name(std::filesystem::path(file).stem().string()), file, builder.place(c)};
  };
  return {read_words(at, "spec files", read), [](const AxisValue& choice, SuiteCase& suite_case) {
            suite_case.spec = choice.value;
            record_location(suite_case, "spec", choice.place);
          }};
}

/// Reads names that refer to parts of the specs. @param of member of the case that receives the name
MatrixAxis read_names(const SpecCursor& at, const std::string& key, std::string SuiteCase::*member,
                      const SuiteBuilder& builder) {
  const auto read = [&](const SpecCursor& c) -> AxisValue {
    const std::string name = c.read_word("a " + key + "'s name");
    return {sanitise_for_file_name(name), name, builder.place(c)};
  };
  return {read_words(at, key == "trajectory" ? "trajectories" : key + "s", read),
          [key, member](const AxisValue& choice, SuiteCase& suite_case) {
            suite_case.*member = choice.value;
            record_location(suite_case, key, choice.place);
          }};
}

/// A file name may start with characters that a case's name may not.
std::string sanitise_name_start(std::string name) {
  if (!name.empty() && !is_case_name_start(name[0])) name[0] = '_';
  return name;
}

/// Enumerates all combinations of the axes, the last axis varying fastest.
void expand_matrix(const std::vector<MatrixAxis>& axes, const std::string& prefix, const SuiteCase& base,
                   const SpecCursor& at, SuiteBuilder& builder) {
  std::size_t count = 1;
  for (const MatrixAxis& axis : axes) {
    count *= axis.choices.size();
    if (count + builder.cases.size() > max_cases) throw_too_many_cases(at);
  }
  for (std::size_t combination = 0; combination < count; ++combination) {
    SuiteCase suite_case = base;
    suite_case.name = prefix;
    std::size_t block = count;
    std::size_t remainder = combination;
    for (const MatrixAxis& axis : axes) {
      block /= axis.choices.size();
      const AxisValue& choice = axis.choices[remainder / block];
      remainder %= block;
      suite_case.name += suite_case.name.empty() ? sanitise_name_start(choice.name) : "_" + choice.name;
      axis.apply(choice, suite_case);
    }
    add_case(builder, std::move(suite_case), at);
  }
}

void read_matrix(const SpecCursor& at, SuiteBuilder& builder) {
  SuiteCase base = builder.defaults;
  MatrixAxes axes;
  std::vector<specification::Field> fields = {
      {"name", Presence::optional,
       [&](const SpecCursor& c) { axes.prefix = c.read_word("a prefix of the cases' names"); }},
      {"spec", Presence::optional, [&](const SpecCursor& c) { axes.specs = read_specs(c, builder); }},
      {"trajectory", Presence::optional,
       [&](const SpecCursor& c) { axes.trajectories = read_names(c, "trajectory", &SuiteCase::trajectory, builder); }},
      {"controller", Presence::optional,
       [&](const SpecCursor& c) { axes.controllers = read_names(c, "controller", &SuiteCase::controller, builder); }},
      {"set", Presence::optional, [&](const SpecCursor& c) {
         std::size_t max_values = max_cases;
         for (const specification::Member& member : list_named_members(c, "parameters {name: [values]}"))
           builder.problems.collect([&] {
             axes.parameters.push_back(read_parameter(member, max_values, builder));
             max_values /= std::max<std::size_t>(1, axes.parameters.back().choices.size());
           });
       }}};
  for (specification::Field& field : make_case_fields(builder, base)) {
    const bool is_axis = std::any_of(fields.begin(), fields.end(),
                                     [&](const specification::Field& axis) { return axis.name == field.name; });
    if (!is_axis) fields.push_back(std::move(field));
  }
  if (!read_fields(at, "a matrix {name, spec, trajectory, controller, set, samples, design, run}", fields)) return;
  std::vector<MatrixAxis> used_axes;
  for (const MatrixAxis* axis : {&axes.specs, &axes.trajectories, &axes.controllers})
    if (!axis->choices.empty()) used_axes.push_back(*axis);
  used_axes.insert(used_axes.end(), axes.parameters.begin(), axes.parameters.end());
  if (used_axes.empty())
    at.fail({.expected = "at least one of 'spec', 'trajectory', 'controller' and 'set'", .found = "none"});
  expand_matrix(used_axes, axes.prefix, base, at, builder);
}

}  // namespace

void read_matrices(const SpecCursor& section, SuiteBuilder& builder) {
  if (!section.is_list()) return read_matrix(section, builder);
  for (const SpecCursor& item : section.items("a list of matrices"))
    builder.problems.collect([&] { read_matrix(item, builder); });
}

}  // namespace balance::batch
