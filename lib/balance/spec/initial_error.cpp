#include "balance/spec/initial_error.hpp"

#include "balance/base/nearest.hpp"
#include "balance/spec/directions.hpp"

#include <algorithm>
#include <optional>
#include <vector>

namespace balance::specification {

void read_initial_error(const SpecCursor& at, StudyBuilder& draft, InitialError& error) {
  std::optional<SpecCursor> joints, tool, angle;
  const auto keep = [](std::optional<SpecCursor>& slot) { return [&slot](const SpecCursor& c) { slot = c; }; };
  std::vector<Field> fields{{"joints", Presence::optional, keep(joints)}, {"tool", Presence::optional, keep(tool)}};
  if (draft.planar()) fields.push_back({"angle", Presence::optional, keep(angle)});
  if (!read_fields(at, "an initial error {joints: …} or {tool: …}", fields)) return;
  if (joints.has_value() == tool.has_value()) at.fail_expected("an initial error of either 'joints' or the 'tool'");
  if (angle && !tool) angle->fail({.expected = "'angle' only with 'tool'", .found = "it with 'joints'"});
  if (tool && !draft.mechanism().tool)
    tool->fail_unless_uncertain("tool", {.expected = "a spec with a tool ('tool: body.point')",
                                         .found = "none",
                                         .hint = "this key is about the tool's pose"});
  if (tool) error.tool = values_of(read_vector(*tool, draft, dimension::length));
  if (angle && angle->is_map()) angle->fail_expected("a number or an expression");
  if (angle) error.angle = read_number(*angle, draft, dimension::angle).value();
  if (!joints) return;
  for (const auto& [coordinate, value] : read_coordinate_values(*joints, draft))
    error.joints.push_back({coordinate, value.value()});
  for (const Member& member : list_members(*joints, "joint coordinates")) {
    const auto& actuators = draft.mechanism().actuators;
    draft.problems.collect([&] {
      const CoordinateId coordinate = find_coordinate(member.key, member.name, draft);
      if (!draft.problems.is_invalid("actuators") && !actuators.empty() &&
          std::find(actuators.begin(), actuators.end(), coordinate) == actuators.end())
        member.key.fail(
            {.expected = "an actuated coordinate (the others follow)", .found = quote_for_message(member.name)});
    });
  }
}

}  // namespace balance::specification
