#include "balance/spec/speed_option.hpp"

#include "balance/spec/option_draft.hpp"

#include <fmt/format.h>

#include <cmath>

namespace balance {

namespace {

using namespace read;

struct ToolComponent {
  const char* name;
  SpeedTerm::Of of;
  int index;
  bool planar, spatial;
};

using enum SpeedTerm::Of;
constexpr ToolComponent tool_components[]{
    {"tool.x", tool_velocity, 0, true, true},     {"tool.y", tool_velocity, 1, true, true},
    {"tool.z", tool_velocity, 2, false, true},    {"tool.u", tool_velocity_own, 0, true, true},
    {"tool.v", tool_velocity_own, 1, true, true}, {"tool.w", tool_velocity_own, 2, false, true},
    {"tool.angle", tool_turning, 2, true, false}, {"tool.rx", tool_turning, 0, false, true},
    {"tool.ry", tool_turning, 1, false, true},    {"tool.rz", tool_turning, 2, false, true},
    {"tool.p", tool_turning_own, 0, false, true}, {"tool.q", tool_turning_own, 1, false, true},
    {"tool.r", tool_turning_own, 2, false, true},
};

/// A coordinate's name is the coordinate, even if it begins with `tool.`.
SpeedTerm term_of(const Cursor& at, const std::string& name, const Draft& draft) {
  const auto& coordinates = draft.mechanism().coordinates;
  std::vector<std::string> names;
  for (std::size_t c = 0; c < coordinates.size(); ++c) {
    if (coordinates[c].name == name) return {.index = static_cast<int>(c)};
    names.push_back(coordinates[c].name);
  }
  for (const ToolComponent& one : tool_components) {
    if (!(draft.planar() ? one.planar : one.spatial)) continue;
    if (one.name == name) return {one.of, one.index};
    names.emplace_back(one.name);
  }
  at.fail({.expected = fmt::format("a joint coordinate or a component of the tool's motion ({})", one_of(names)),
           .found = in_quotes(name),
           .hint = nearest_is(name, names)});
}

Speed read_speed(const Member& member, Draft& draft) {
  Speed speed{member.name, {}};
  if (member.value.is_scalar()) {
    speed.terms.push_back(term_of(member.value, member.value.word("what the speed is"), draft));
    return speed;
  }
  for (const Member& one : members(member.value, "a joint coordinate, or a mapping of such to factors")) {
    SpeedTerm term = term_of(one.key, one.name, draft);
    if (!one.value.is_scalar()) one.value.expected("a number");
    term.factor = read_number(one.value, draft, dimension::none).value();
    if (!std::isfinite(term.factor)) one.value.expected("a finite number");
    speed.terms.push_back(term);
  }
  if (speed.terms.empty()) member.value.fail({.expected = "at least one term", .found = member.value.found()});
  return speed;
}

}  // namespace

std::vector<Speed> read_speeds(const std::string& text, const char* option, const Study& study) {
  Draft draft = draft_of(study, option);
  std::vector<Speed> speeds;
  draft.problems.guard([&] {
    need_text(text, "speeds");
    const Node root = parse_yaml(text.find('{') == 0 ? text : "{" + text + "}", draft.problems);
    for (const Member& member : named_members(Cursor(root, "", draft.problems), "a mapping of speeds", Names::single))
      draft.problems.guard([&] { speeds.push_back(read_speed(member, draft)); });
    if (root.items.empty()) Cursor(root, "", draft.problems).fail({.expected = "at least one speed", .found = "none"});
  });
  draft.problems.throw_all();
  return speeds;
}

}  // namespace balance
