// Every spec with every trajectory with every value of each parameter.

#include "balance/read/nearest.hpp"
#include "balance/read/suite_case.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <filesystem>

namespace balance::read {

namespace {

/// One value of one axis: what it does to a case, and its part of the case's name.
struct Choice {
  std::string name;
  std::function<void(SuiteCase&)> apply;
};

using Axis = std::vector<Choice>;

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
Axis read_words(const Cursor& at, const std::string& what, const std::function<Choice(const Cursor&)>& read) {
  Axis axis;
  if (!at.is_list()) {
    axis.push_back(read(at));
    return axis;
  }
  for (const Cursor& item : at.items(what)) at.problems().guard([&] { axis.push_back(read(item)); });
  if (at.node().items.empty()) at.expected("at least one of " + what);
  return axis;
}

Choice parameter_choice(const std::string& name, const std::string& value, const std::string& place) {
  return {name + "=" + for_file(value), [=](SuiteCase& one) {
            std::erase_if(one.set, [&](const auto& pair) { return pair.first == name; });
            one.set.emplace_back(name, value);
            note_place(one, "set." + name, place);
          }};
}

/// `{from: 0, to: 1, count: 5}`: evenly spaced, both ends included.
Axis read_range(const Cursor& at, const std::string& name, const SuiteDraft& draft) {
  double from = 0, to = 0;
  long count = 0;
  const bool read = read_fields(at, "values {from, to, count}",
                                {{"from", Need::required, [&](const Cursor& c) { from = read_plain(c); }},
                                 {"to", Need::required, [&](const Cursor& c) { to = read_plain(c); }},
                                 {"count", Need::required, [&](const Cursor& c) { count = read_samples(c); }}});
  Axis axis;
  if (!read) return axis;
  if (static_cast<std::size_t>(count) > most_cases)
    at.fail(fmt::format("expected at most {} values, found {}", most_cases, count));
  for (long i = 0; i < count; ++i) {
    const double part = static_cast<double>(i) / static_cast<double>(count - 1);
    const double value = i + 1 == count ? to : from + (to - from) * part;
    axis.push_back(parameter_choice(name, fmt::format("{}", value), draft.place(at)));
  }
  return axis;
}

Axis read_parameter(const Member& member, const SuiteDraft& draft) {
  if (member.value.is_map()) return read_range(member.value, member.name, draft);
  return read_words(member.value, "values",
                    [&](const Cursor& c) { return parameter_choice(member.name, read_value(c), draft.place(c)); });
}

struct Axes {
  std::string prefix;
  Axis specs, trajectories, controllers;
  std::vector<Axis> parameters;
};

Axis read_specs(const Cursor& at, const SuiteDraft& draft) {
  return read_words(at, "spec files", [&](const Cursor& c) -> Choice {
    const std::string file = c.word("the name of a spec file");
    return {for_file(std::filesystem::path(file).stem().string()), [file, place = draft.place(c)](SuiteCase& one) {
              one.spec = file;
              note_place(one, "spec", place);
            }};
  });
}

Axis read_trajectory_names(const Cursor& at, const SuiteDraft& draft) {
  return read_words(at, "trajectories", [&](const Cursor& c) -> Choice {
    const std::string name = c.word("a trajectory's name");
    return {for_file(name), [name, place = draft.place(c)](SuiteCase& one) {
              one.trajectory = name;
              note_place(one, "trajectory", place);
            }};
  });
}

Axis read_controller_names(const Cursor& at, const SuiteDraft& draft) {
  return read_words(at, "controllers", [&](const Cursor& c) -> Choice {
    const std::string name = c.word("a controller's name");
    return {for_file(name), [name, place = draft.place(c)](SuiteCase& one) {
              one.controller = name;
              note_place(one, "controller", place);
            }};
  });
}

/// Counts through the axes, the last of them fastest.
void expand(const std::vector<Axis>& axes, const std::string& prefix, const SuiteCase& base, const Cursor& at,
            SuiteDraft& draft) {
  std::size_t count = 1;
  for (const Axis& axis : axes) {
    count *= axis.size();
    if (count + draft.cases.size() > most_cases)
      at.fail(fmt::format("expected at most {} cases, found more", most_cases));
  }
  for (std::size_t number = 0; number < count; ++number) {
    SuiteCase one = base;
    one.name = prefix;
    std::size_t block = count;
    std::size_t rest = number;
    for (const Axis& axis : axes) {
      block /= axis.size();
      const Choice& choice = axis[rest / block];
      rest %= block;
      one.name += (one.name.empty() ? "" : "_") + choice.name;
      choice.apply(one);
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
      {"trajectory", Need::optional, [&](const Cursor& c) { axes.trajectories = read_trajectory_names(c, draft); }},
      {"controller", Need::optional, [&](const Cursor& c) { axes.controllers = read_controller_names(c, draft); }},
      {"set", Need::optional, [&](const Cursor& c) {
         for (const Member& member : named_members(c, "parameters {name: [values]}"))
           draft.problems.guard([&] { axes.parameters.push_back(read_parameter(member, draft)); });
       }}};
  for (Field& field : case_fields(draft, base))
    if (field.name == "samples" || field.name == "design") fields.push_back(std::move(field));
  if (!read_fields(at, "a matrix {name, spec, trajectory, controller, set, samples, design}", fields)) return;
  std::vector<Axis> all;
  for (const Axis* axis : {&axes.specs, &axes.trajectories, &axes.controllers})
    if (!axis->empty()) all.push_back(*axis);
  all.insert(all.end(), axes.parameters.begin(), axes.parameters.end());
  if (all.empty()) at.fail("expected at least one of 'spec', 'trajectory', 'controller' and 'set', found none");
  expand(all, axes.prefix, base, at, draft);
}

}  // namespace

void read_matrices(const Cursor& section, SuiteDraft& draft) {
  if (!section.is_list()) return read_matrix(section, draft);
  for (const Cursor& item : section.items("a list of matrices"))
    draft.problems.guard([&] { read_matrix(item, draft); });
}

}  // namespace balance::read
