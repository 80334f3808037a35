// Every spec with every trajectory with every value of each parameter.

#include "balance/base/nearest.hpp"
#include "balance/read/suite_case.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>

namespace balance::read {

namespace {

/// One value of one axis, its part of the cases' names, and where it stands.
struct Choice {
  std::string name, value;
  SpecPlace place;
};

/// What varies, and what a choice of it does to a case.
struct Axis {
  std::vector<Choice> choices;
  std::function<void(const Choice&, SuiteCase&)> apply;
};

double read_plain(const Cursor& at) {
  const std::string& text = at.word("a number");
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) at.expected("a number");
  return value;
}

/// What a file's name cannot hold becomes `_`.
std::string for_file(std::string text) {
  for (char& c : text)
    if (!std::isalnum(static_cast<unsigned char>(c)) && std::string_view("_-.+").find(c) == std::string_view::npos)
      c = '_';
  return text;
}

/// One or several words, each a choice.
std::vector<Choice> read_words(const Cursor& at, const std::string& what,
                               const std::function<Choice(const Cursor&)>& read) {
  if (!at.is_list()) return {read(at)};
  std::vector<Choice> choices;
  for (const Cursor& item : at.items(what)) at.problems().guard([&] { choices.push_back(read(item)); });
  if (at.node().items.empty()) at.expected("at least one of " + what);
  return choices;
}

[[noreturn]] void too_many(const Cursor& at) {
  at.fail({.expected = fmt::format("at most {} cases", most_cases), .found = "more"});
}

/// `{from: 0, to: 1, count: 5}`: evenly spaced, both ends included. @param most how many values may be
std::vector<Choice> read_range(const Cursor& at, const std::string& name, std::size_t most, const SuiteDraft& draft) {
  double from = 0, to = 0;
  long count = 0;
  const bool read = read_fields(at, "values {from, to, count}",
                                {{"from", Need::required, [&](const Cursor& c) { from = read_plain(c); }},
                                 {"to", Need::required, [&](const Cursor& c) { to = read_plain(c); }},
                                 {"count", Need::required, [&](const Cursor& c) { count = read_samples(c); }}});
  std::vector<Choice> choices;
  if (!read) return choices;
  if (static_cast<std::size_t>(count) > most) too_many(at);
  const SpecPlace place = draft.place(at);
  for (long i = 0; i < count; ++i) {
    const double part = static_cast<double>(i) / static_cast<double>(count - 1);
    const std::string value = fmt::format("{}", i + 1 == count ? to : from + (to - from) * part);
    choices.push_back({name + "=" + for_file(value), value, place});
  }
  return choices;
}

Axis read_parameter(const Member& member, std::size_t most, const SuiteDraft& draft) {
  const std::string& name = member.name;
  Axis axis;
  axis.apply = [name](const Choice& choice, SuiteCase& one) {
    std::erase_if(one.set, [&](const auto& pair) { return pair.first == name; });
    one.set.emplace_back(name, choice.value);
    note_place(one, "set." + name, choice.place);
  };
  axis.choices = member.value.is_map() ? read_range(member.value, name, most, draft)
                                       : read_words(member.value, "values", [&](const Cursor& c) -> Choice {
                                           const std::string value = read_value(c);
                                           return {name + "=" + for_file(value), value, draft.place(c)};
                                         });
  return axis;
}

struct Axes {
  std::string prefix;
  Axis specs, trajectories, controllers;
  std::vector<Axis> parameters;
};

Axis read_specs(const Cursor& at, const SuiteDraft& draft) {
  const auto read = [&](const Cursor& c) -> Choice {
    const std::string file = c.word("the name of a spec file");
    return {for_file(std::filesystem::path(file).stem().string()), file, draft.place(c)};
  };
  return {read_words(at, "spec files", read), [](const Choice& choice, SuiteCase& one) {
            one.spec = choice.value;
            note_place(one, "spec", choice.place);
          }};
}

/// Names of things in the specs. @param of whose
Axis read_names(const Cursor& at, const std::string& key, std::string SuiteCase::*of, const SuiteDraft& draft) {
  const auto read = [&](const Cursor& c) -> Choice {
    const std::string name = c.word("a " + key + "'s name");
    return {for_file(name), name, draft.place(c)};
  };
  return {read_words(at, key == "trajectory" ? "trajectories" : key + "s", read),
          [key, of](const Choice& choice, SuiteCase& one) {
            one.*of = choice.value;
            note_place(one, key, choice.place);
          }};
}

/// A file's name may begin as a case's may not.
std::string for_beginning(std::string name) {
  if (!name.empty() && !begins_name(name[0])) name[0] = '_';
  return name;
}

/// Counts through the axes, the last of them fastest.
void expand(const std::vector<Axis>& axes, const std::string& prefix, const SuiteCase& base, const Cursor& at,
            SuiteDraft& draft) {
  std::size_t count = 1;
  for (const Axis& axis : axes) {
    count *= axis.choices.size();
    if (count + draft.cases.size() > most_cases) too_many(at);
  }
  for (std::size_t number = 0; number < count; ++number) {
    SuiteCase one = base;
    one.name = prefix;
    std::size_t block = count;
    std::size_t rest = number;
    for (const Axis& axis : axes) {
      block /= axis.choices.size();
      const Choice& choice = axis.choices[rest / block];
      rest %= block;
      one.name += one.name.empty() ? for_beginning(choice.name) : "_" + choice.name;
      axis.apply(choice, one);
    }
    add_case(draft, std::move(one), at);
  }
}

void read_matrix(const Cursor& at, SuiteDraft& draft) {
  SuiteCase base = draft.defaults;
  Axes axes;
  std::vector<Field> fields = {
      {"name", Need::optional, [&](const Cursor& c) { axes.prefix = c.word("how the cases' names begin"); }},
      {"spec", Need::optional, [&](const Cursor& c) { axes.specs = read_specs(c, draft); }},
      {"trajectory", Need::optional,
       [&](const Cursor& c) { axes.trajectories = read_names(c, "trajectory", &SuiteCase::trajectory, draft); }},
      {"controller", Need::optional,
       [&](const Cursor& c) { axes.controllers = read_names(c, "controller", &SuiteCase::controller, draft); }},
      {"set", Need::optional, [&](const Cursor& c) {
         std::size_t most = most_cases;
         for (const Member& member : named_members(c, "parameters {name: [values]}"))
           draft.problems.guard([&] {
             axes.parameters.push_back(read_parameter(member, most, draft));
             most /= std::max<std::size_t>(1, axes.parameters.back().choices.size());
           });
       }}};
  for (Field& field : case_fields(draft, base))
    if (field.name == "samples" || field.name == "design") fields.push_back(std::move(field));
  if (!read_fields(at, "a matrix {name, spec, trajectory, controller, set, samples, design}", fields)) return;
  std::vector<Axis> all;
  for (const Axis* axis : {&axes.specs, &axes.trajectories, &axes.controllers})
    if (!axis->choices.empty()) all.push_back(*axis);
  all.insert(all.end(), axes.parameters.begin(), axes.parameters.end());
  if (all.empty())
    at.fail({.expected = "at least one of 'spec', 'trajectory', 'controller' and 'set'", .found = "none"});
  expand(all, axes.prefix, base, at, draft);
}

}  // namespace

void read_matrices(const Cursor& section, SuiteDraft& draft) {
  if (!section.is_list()) return read_matrix(section, draft);
  for (const Cursor& item : section.items("a list of matrices"))
    draft.problems.guard([&] { read_matrix(item, draft); });
}

}  // namespace balance::read
