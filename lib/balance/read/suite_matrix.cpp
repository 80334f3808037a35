// Every spec with every trajectory with every value of each parameter.

#include "balance/base/nearest.hpp"
#include "balance/read/suite_case.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>

namespace balance::specification {

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
