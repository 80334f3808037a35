#include "balance/spec/model_override.hpp"

#include "balance/base/error.hpp"
#include "balance/base/nearest.hpp"
#include "balance/spec/reading.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace balance::specification {

namespace {

/// What a model may have other numbers in.
constexpr std::array overridable_sections{"gravity",        "ground",   "bodies", "joints", "couplings", "constraints",
                                          "counterweights", "payloads", "discs",  "loads",  "springs",   "friction"};

/// "bodies.link1.com[0]" → bodies, link1, com, 0.
std::vector<std::string> split_key_path(const std::string& path) {
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
YamlNode& find_path_entry(YamlNode& node, const std::string& step, const SpecCursor& named, const std::string& path) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < node.items.size(); ++i) {
    names.push_back(node.kind == YamlNode::Kind::map ? node.keys[i].text : std::to_string(i));
    if (names.back() == step) return node.items[i];
  }
  // A coordinate's own name may have a dot: `friction.J.slide.coulomb`.
  named.fail({.expected = "a parameter or a number of this spec",
              .found = fmt::format("{}: there is no {} in {}", quote_for_message(path), quote_for_message(step),
                                   quote_for_message(path.substr(0, path.rfind(step) - 1))),
              .hint = format_nearest_name(step, names)});
}

YamlNode& number_at(YamlNode& root, const Member& member, const SpecParameters& parameters) {
  const std::vector<std::string> steps = split_key_path(member.name);
  if (steps.size() < 2 ||
      std::find(overridable_sections.begin(), overridable_sections.end(), steps[0]) == overridable_sections.end()) {
    std::vector<std::string> names = parameters.names();
    names.insert(names.end(), overridable_sections.begin(), overridable_sections.end());
    member.key.fail(
        {.expected = fmt::format("a parameter ({}) or the path of a number such as bodies.link1.mass",
                                 parameters.names().empty() ? "there are none" : join_alternatives(parameters.names())),
         .found = quote_for_message(member.name),
         .hint = format_nearest_name(steps[0], names)});
  }
  YamlNode* node = &root;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    // Names of coordinates and of what parts consist of have dots of their own.
    std::string step = steps[i];
    const auto is_key = [&](const std::string& name) {
      return node->kind == YamlNode::Kind::map &&
             std::any_of(node->keys.begin(), node->keys.end(), [&](const YamlNode& key) { return key.text == name; });
    };
    std::string longer = step;
    for (std::size_t k = i + 1; !is_key(step) && k < steps.size(); ++k)
      if (longer += "." + steps[k]; is_key(longer)) {
        step = longer;
        i = k;
      }
    node = &find_path_entry(*node, step, member.key, member.name);
  }
  const bool free =
      node->kind == YamlNode::Kind::map &&
      std::any_of(node->keys.begin(), node->keys.end(), [](const YamlNode& key) { return key.text == "free"; });
  if (node->kind != YamlNode::Kind::scalar && !free)
    member.key.fail({.expected = "the path of a single number",
                     .found = fmt::format("{}, which is {}", quote_for_message(member.name),
                                          node->kind == YamlNode::Kind::list ? "a list" : "a mapping")});
  return *node;
}

/// @param overrides take what names a parameter, `root` all else
void replace_number(const Member& member, YamlNode& root, SpecParameters::Overrides& overrides,
                    const StudyBuilder& draft) {
  const std::string& text = member.value.read_word("a number or an expression");
  const auto& names = draft.parameters.names();
  if (std::find(names.begin(), names.end(), member.name) != names.end()) {
    std::erase_if(overrides, [&](const auto& pair) { return pair.first == member.name; });
    overrides.emplace_back(member.name, text);
    return;
  }
  YamlNode& number = number_at(root, member, draft.parameters);
  number.kind = YamlNode::Kind::scalar;
  number.text = text;
  number.keys.clear();
  number.items.clear();
}

/// The mechanism that the spec would describe with other numbers.
Mechanism read_overridden_mechanism(const SpecCursor& at, const YamlNode& root,
                                    const SpecParameters::Overrides& overrides, StudyBuilder& draft) {
  YamlNode changed = root;
  SpecParameters::Overrides all = overrides;
  bool right = true;
  for (const Member& member : list_members(at, "numbers {name or path: value}"))
    right = draft.problems.collect([&] { replace_number(member, changed, all, draft); }) && right;
  if (!right) throw CascadingError();
  try {
    return read_mechanism_alone(changed, draft.study.spec_file, draft.problems, all);
  } catch (const SpecError& error) {
    const Diagnostic& first = error.diagnostics().front();
    at.fail({.message = "expected numbers that a mechanism may have, but with these: " + first.text(),
             .expected = "numbers that a mechanism may have",
             .found = first.text()});
  }
}

/// @param sure that nothing is missing in the mechanism because of a mistake
void remove_mechanism_elements(const SpecCursor& at, Mechanism& mechanism, bool sure) {
  std::vector<std::string> known;
  bool found = false;
  const std::string& name = at.read_word("the name of something that the controller does not know");
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
  if (!found && !sure) throw CascadingError();
  if (!found) fail_expected_one_of(at, "something that can be left out", known);
}

/// Mass and inertia alike, as if the density were another.
void scale_masses(const SpecCursor& at, StudyBuilder& draft, Mechanism& mechanism) {
  const auto factor_of = [&](const SpecCursor& c) {
    if (c.is_map()) c.fail_expected("a factor > 0");
    return read_number(c, draft, dimension::dimensionless, SignConstraint::positive).value();
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
  for (const Member& member : list_members(at, "a factor, or factors {name: factor}")) {
    draft.problems.collect([&] {
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
      if (!found && !draft.is_mechanism_valid) throw CascadingError();
      if (!found)
        member.key.fail({.expected = fmt::format("something with a mass ({})", join_alternatives(names)),
                         .found = quote_for_message(member.name),
                         .hint = format_nearest_name(member.name, names)});
    });
  }
}

}  // namespace

Mechanism read_controller_model(const SpecCursor& at, const YamlNode& root, const SpecParameters::Overrides& overrides,
                                StudyBuilder& draft) {
  std::optional<SpecCursor> without, mass_scale, set;
  const auto keep = [](std::optional<SpecCursor>& slot) { return [&slot](const SpecCursor& c) { slot = c; }; };
  Mechanism model = draft.study.mechanism;
  read_fields(at, "what the controller believes {without, mass_scale, set}",
              {{"without", Presence::optional, keep(without)},
               {"mass_scale", Presence::optional, keep(mass_scale)},
               {"set", Presence::optional, keep(set)}});
  // With other numbers the whole spec is read again, so that it must be right.
  const bool sure = draft.is_mechanism_valid;
  if (set)
    draft.problems.collect([&] {
      if (!sure) throw CascadingError();
      model = read_overridden_mechanism(*set, root, overrides, draft);
    });
  // Scaled first: what is left out must still be found by its name.
  if (mass_scale) draft.problems.collect([&] { scale_masses(*mass_scale, draft, model); });
  if (without && !without->is_list()) remove_mechanism_elements(*without, model, sure);
  if (without && without->is_list())
    for (const SpecCursor& item : without->items("a list of names"))
      draft.problems.collect([&] { remove_mechanism_elements(item, model, sure); });
  return model;
}

}  // namespace balance::specification
