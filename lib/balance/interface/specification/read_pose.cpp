#include "balance/interface/specification/read_pose.hpp"

#include "balance/foundation/base/spelling.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>

namespace balance::specification {

namespace {

void require_tool(const SpecCursor& at, const StudyBuilder& draft) {
  if (!draft.mechanism().tool)
    at.fail_unless_uncertain("tool", {.expected = "a spec with a tool ('tool: body.point')",
                                      .found = "none",
                                      .hint = "this key refers to the tool's pose"});
}

}  // namespace

trajectory::PoseTargetOf<Expression> read_pose(const SpecCursor& at, StudyBuilder& draft) {
  trajectory::PoseTargetOf<Expression> pose;
  std::vector<Field> fields{
      {"tool", Presence::optional,
       [&](const SpecCursor& c) {
         pose.tool = read_vector(c, draft, dimension::length);
         require_tool(c, draft);
       }},
      {"joints", Presence::optional,
       [&](const SpecCursor& c) {
         pose.joints = read_coordinate_values(c, draft);
         if (c.node().items.empty()) c.fail_expected("values of at least one joint coordinate");
       }},
      {"com", Presence::optional, [&](const SpecCursor& c) { pose.com = read_vector(c, draft, dimension::length); }}};
  const auto read_orientation = [&](Matrix3E (*read)(const SpecCursor&, StudyBuilder&)) {
    return [&pose, &draft, read](const SpecCursor& c) {
      if (pose.orientation) c.fail({.expected = "'rpy' or 'quaternion'", .found = "both"});
      pose.orientation = read(c, draft);
      require_tool(c, draft);
    };
  };
  if (draft.planar()) {
    fields.push_back({"angle", Presence::optional, [&](const SpecCursor& c) {
                        pose.angle = read_number(c, draft, dimension::angle);
                        require_tool(c, draft);
                      }});
  } else {
    fields.push_back({"rpy", Presence::optional, read_orientation(read_rpy)});
    fields.push_back({"quaternion", Presence::optional, read_orientation(read_quaternion)});
  }
  if (read_fields(at, "a pose {tool: …}, {joints: …} or {com: …}", fields) && at.node().items.empty())
    at.fail_expected("a pose {tool: …}, {joints: …} or {com: …}");
  return pose;
}

void check_pose(const SpecCursor& at, const trajectory::PoseTargetOf<Expression>& pose,
                const DriveRequirements& requirements, const StudyBuilder& draft) {
  const auto has = [&](auto... c) {
    return ((std::find(requirements.components.begin(), requirements.components.end(), c) !=
             requirements.components.end()) ||
            ...);
  };
  using enum trajectory::Component;
  switch (requirements.drive) {
    case DriveKind::joints:
      if (pose.joints.empty())
        at.fail({.expected = "'joints: {…}', which 'drive: joints' moves", .found = "a pose without it"});
      return;
    case DriveKind::tool:
      if ((requirements.components.empty() || has(x, y, z)) && !pose.tool)
        at.fail({.expected = "'tool: […]', which 'drive: tool' moves", .found = "a pose without it"});
      if (has(rx, ry, rz) && draft.planar() && !pose.angle)
        at.fail({.expected = "'angle', which is among the trajectory's components", .found = "a pose without it"});
      if (has(rx, ry, rz) && !draft.planar() && !pose.orientation)
        at.fail({.expected = "'rpy' or 'quaternion', since the trajectory's components turn the tool",
                 .found = "a pose without it"});
      return;
    case DriveKind::com:
      if (!pose.com && !pose.tool && pose.joints.empty())
        at.fail({.expected = "'com', 'tool' or 'joints', which give 'drive: com' its centre of mass",
                 .found = "none of them"});
      return;
  }
}

namespace {

/// The first value of each coordinate.
std::map<int, model::CoordinateValueOf<Expression>> by_coordinate(const trajectory::PoseTargetOf<Expression>& pose) {
  std::map<int, model::CoordinateValueOf<Expression>> values;
  for (const auto& value : pose.joints) values.emplace(value.coordinate, value);
  return values;
}

}  // namespace

void match_pose(const SpecCursor& at, trajectory::PoseTargetOf<Expression>& pose,
                const trajectory::PoseTargetOf<Expression>& model, DriveKind drive, const StudyBuilder& draft) {
  const auto require_same = [&](bool in_pose, bool in_model, const char* what) {
    if (in_pose != in_model)
      at.fail({.expected = "the same quantities in all poses of a trajectory",
               .found = fmt::format("one with and one without {}", what)});
  };
  if (drive == DriveKind::tool) {
    require_same(pose.angle.has_value(), model.angle.has_value(), "'angle'");
    require_same(pose.orientation.has_value(), model.orientation.has_value(), "'rpy' or 'quaternion'");
  }
  if (drive != DriveKind::joints) return;
  const auto values = by_coordinate(pose), model_values = by_coordinate(model);
  std::vector<model::CoordinateValueOf<Expression>> ordered;
  for (const auto& model_value : model.joints) {
    const auto match = values.find(model_value.coordinate);
    const std::string& name = draft.mechanism().coordinates[static_cast<std::size_t>(model_value.coordinate)].name;
    if (match == values.end())
      at.fail({.expected = fmt::format("a value of {} as in the trajectory's other poses", quote_for_message(name)),
               .found = "none"});
    ordered.push_back(match->second);
  }
  for (const auto& value : pose.joints) {
    const std::string& name = draft.mechanism().coordinates[static_cast<std::size_t>(value.coordinate)].name;
    if (!model_values.contains(value.coordinate))
      at.fail({.expected = "the same joints as in the trajectory's other poses",
               .found = fmt::format("also {}", quote_for_message(name))});
  }
  pose.joints = ordered;
}

bool overrides_pose(const trajectory::PoseTargetOf<Expression>& pose, DriveKind drive) {
  const bool has_joints = !pose.joints.empty(), has_point = pose.tool || pose.com;
  return drive == DriveKind::joints ? !has_joints && has_point
                                    : drive == DriveKind::tool && !pose.tool && (has_joints || pose.com);
}

}  // namespace balance::specification
