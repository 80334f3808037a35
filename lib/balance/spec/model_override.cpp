#include "balance/spec/model_override.hpp"

#include "balance/base/error.hpp"
#include "balance/base/nearest.hpp"
#include "balance/spec/reading.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace balance::read {

namespace {

/// What a model may have other numbers in.
constexpr std::array changeable{"gravity",        "ground",   "bodies", "joints", "couplings", "constraints",
                                "counterweights", "payloads", "discs",  "loads",  "springs",   "friction"};

/// "bodies.link1.com[0]" → bodies, link1, com, 0.
std::vector<std::string> steps_of(const std::string& path) {
  std::vector<std::string> steps(1);
  for (const char c : path) {
    if (c == '.' || c == '[')
      steps.emplace_back();
    else if (c != ']')
      steps.back() += c;
  }
  return steps;
}

/// The entry of a mapping or a list that a step of a path names.
Node& entry(Node& node, const std::string& step, const Cursor& named, const std::string& path) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < node.items.size(); ++i) {
    names.push_back(node.kind == Node::Kind::map ? node.keys[i].text : std::to_string(i));
    if (names.back() == step) return node.items[i];
  }
  // A coordinate's own name may have a dot: `friction.J.slide.coulomb`.
  named.fail({.expected = "a parameter or a number of this spec",
              .found = fmt::format("{}: there is no {} in {}", in_quotes(path), in_quotes(step),
                                   in_quotes(path.substr(0, path.rfind(step) - 1))),
              .hint = nearest_is(step, names)});
}

Node& number_at(Node& root, const Member& member, const Parameters& parameters) {
  const std::vector<std::string> steps = steps_of(member.name);
  if (steps.size() < 2 || std::find(changeable.begin(), changeable.end(), steps[0]) == changeable.end()) {
    std::vector<std::string> names = parameters.names();
    names.insert(names.end(), changeable.begin(), changeable.end());
    member.key.fail(
        {.expected = fmt::format("a parameter ({}) or the path of a number such as bodies.link1.mass",
                                 parameters.names().empty() ? "there are none" : one_of(parameters.names())),
         .found = in_quotes(member.name),
         .hint = nearest_is(steps[0], names)});
  }
  Node* node = &root;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    // Names of coordinates and of what parts consist of have dots of their own.
    std::string step = steps[i];
    const auto is_key = [&](const std::string& name) {
      return node->kind == Node::Kind::map &&
             std::any_of(node->keys.begin(), node->keys.end(), [&](const Node& key) { return key.text == name; });
    };
    std::string longer = step;
    for (std::size_t k = i + 1; !is_key(step) && k < steps.size(); ++k)
      if (longer += "." + steps[k]; is_key(longer)) {
        step = longer;
        i = k;
      }
    node = &entry(*node, step, member.key, member.name);
  }
  const bool free = node->kind == Node::Kind::map && std::any_of(node->keys.begin(), node->keys.end(),
                                                                 [](const Node& key) { return key.text == "free"; });
  if (node->kind != Node::Kind::scalar && !free)
    member.key.fail({.expected = "the path of a single number",
                     .found = fmt::format("{}, which is {}", in_quotes(member.name),
                                          node->kind == Node::Kind::list ? "a list" : "a mapping")});
  return *node;
}

/// @param overrides take what names a parameter, `root` all else
void replace_number(const Member& member, Node& root, Parameters::Overrides& overrides, const Draft& draft) {
  const std::string& text = member.value.word("a number or an expression");
  const auto& names = draft.parameters.names();
  if (std::find(names.begin(), names.end(), member.name) != names.end()) {
    std::erase_if(overrides, [&](const auto& pair) { return pair.first == member.name; });
    overrides.emplace_back(member.name, text);
    return;
  }
  Node& number = number_at(root, member, draft.parameters);
  number.kind = Node::Kind::scalar;
  number.text = text;
  number.keys.clear();
  number.items.clear();
}

/// The mechanism that the spec would describe with other numbers.
Mechanism with_other_numbers(const Cursor& at, const Node& root, const Parameters::Overrides& overrides, Draft& draft) {
  Node changed = root;
  Parameters::Overrides all = overrides;
  bool right = true;
  for (const Member& member : members(at, "numbers {name or path: value}"))
    right = draft.problems.guard([&] { replace_number(member, changed, all, draft); }) && right;
  if (!right) throw Consequence();
  try {
    return read_mechanism_alone(changed, draft.study.spec_file, draft.problems, all);
  } catch (const SpecError& error) {
    const Mistake& first = error.mistakes().front();
    at.fail({.message = "expected numbers that a mechanism may have, but with these: " + first.text(),
             .expected = "numbers that a mechanism may have",
             .found = first.text()});
  }
}

/// @param sure that nothing is missing in the mechanism because of a mistake
void leave_out(const Cursor& at, Mechanism& mechanism, bool sure) {
  std::vector<std::string> known;
  bool found = false;
  const std::string& name = at.word("the name of something that the controller does not know");
  const auto erase = [&](auto& list) {
    for (const auto& one : list) known.push_back(one.name);
    found = std::erase_if(list, [&](const auto& one) { return one.name == name; }) > 0 || found;
  };
  erase(mechanism.attachments);
  erase(mechanism.discs);
  erase(mechanism.loads);
  erase(mechanism.springs);
  if (found) return;
  const auto erase_all = [&](const char* section, auto& list, auto&& which) {
    if (!list.empty()) known.emplace_back(section);
    if (name != section) return;
    found = true;
    std::erase_if(list, which);
  };
  const auto of = [](AttachmentKind kind) { return [kind](const Attachment& one) { return one.kind == kind; }; };
  const auto all = [](const auto&) { return true; };
  erase_all("payloads", mechanism.attachments, of(AttachmentKind::payload));
  erase_all("counterweights", mechanism.attachments, of(AttachmentKind::counterweight));
  erase_all("discs", mechanism.discs, all);
  erase_all("loads", mechanism.loads, all);
  erase_all("springs", mechanism.springs, all);
  erase_all("friction", mechanism.friction, all);
  if (!found && !sure) throw Consequence();
  if (!found) expected_one_of(at, "something that can be left out", known);
}

/// Mass and inertia alike, as if the density were another.
void scale_masses(const Cursor& at, Draft& draft, Mechanism& mechanism) {
  const auto factor_of = [&](const Cursor& c) {
    if (c.is_map()) c.expected("a factor > 0");
    return read_number(c, draft, dimension::none, Sign::positive).value();
  };
  const auto scale = [](auto& one, double factor) {
    one.mass *= factor;
    one.inertia *= factor;
  };
  if (!at.is_map()) {
    const double factor = factor_of(at);
    for (std::size_t b = 1; b < mechanism.bodies.size(); ++b) scale(mechanism.bodies[b], factor);
    for (Attachment& one : mechanism.attachments) scale(one, factor);
    for (Disc& one : mechanism.discs) scale(one, factor);
    return;
  }
  for (const Member& member : members(at, "a factor, or factors {name: factor}")) {
    draft.problems.guard([&] {
      const double factor = factor_of(member.value);
      std::vector<std::string> names;
      bool found = false;
      const auto look = [&](auto begin, auto end) {
        for (auto one = begin; one != end; ++one) {
          names.push_back(one->name);
          if (one->name != member.name) continue;
          scale(*one, factor);
          found = true;
        }
      };
      look(mechanism.bodies.begin() + 1, mechanism.bodies.end());
      look(mechanism.attachments.begin(), mechanism.attachments.end());
      look(mechanism.discs.begin(), mechanism.discs.end());
      if (!found && !draft.mechanism_is_right) throw Consequence();
      if (!found)
        member.key.fail({.expected = fmt::format("something with a mass ({})", one_of(names)),
                         .found = in_quotes(member.name),
                         .hint = nearest_is(member.name, names)});
    });
  }
}

}  // namespace

Mechanism read_model(const Cursor& at, const Node& root, const Parameters::Overrides& overrides, Draft& draft) {
  std::optional<Cursor> without, mass_scale, set;
  const auto keep = [](std::optional<Cursor>& slot) { return [&slot](const Cursor& c) { slot = c; }; };
  Mechanism model = draft.study.mechanism;
  read_fields(at, "what the controller believes {without, mass_scale, set}",
              {{"without", Need::optional, keep(without)},
               {"mass_scale", Need::optional, keep(mass_scale)},
               {"set", Need::optional, keep(set)}});
  // With other numbers the whole spec is read again, so that it must be right.
  const bool sure = draft.mechanism_is_right;
  if (set)
    draft.problems.guard([&] {
      if (!sure) throw Consequence();
      model = with_other_numbers(*set, root, overrides, draft);
    });
  // Scaled first: what is left out must still be found by its name.
  if (mass_scale) draft.problems.guard([&] { scale_masses(*mass_scale, draft, model); });
  if (without && !without->is_list()) leave_out(*without, model, sure);
  if (without && without->is_list())
    for (const Cursor& item : without->items("a list of names"))
      draft.problems.guard([&] { leave_out(item, model, sure); });
  return model;
}

}  // namespace balance::read
