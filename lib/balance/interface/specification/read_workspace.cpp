#include "balance/interface/specification/read_workspace.hpp"

#include "balance/interface/specification/read_pose.hpp"
#include "balance/interface/specification/read_temporary_payloads.hpp"
#include "balance/mechanics/trajectory/time_grid.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace balance::specification {

namespace {

constexpr long max_workspace_poses = 10'000;
constexpr long default_workspace_poses = 9;

/// One coordinate of the box: a stretch, or a value that all poses share.
struct PoseInterval {
  Expression begin, end;
  bool open = false;  ///< a stretch
  long samples = 1;

  Expression at(long k) const {
    if (!open) return begin;
    return begin + (end - begin) * (static_cast<double>(k) / static_cast<double>(samples - 1));
  }
};

/// What a pose is told in, and the sides in that order.
struct PoseBox {
  std::vector<int> joints;
  bool tool = false, angle = false;
  std::optional<Matrix3E> orientation;
  std::vector<PoseInterval> sides;
  std::optional<SpecCursor> samples;
};

/// `[0.1, 0.4]`, or one number.
PoseInterval read_side(const SpecCursor& at, StudyBuilder& draft, Dimension dimension) {
  if (!at.is_list()) {
    const Expression value = read_number(at, draft, dimension);
    return {value, value};
  }
  const auto ends = at.items("a number or [from, to]", 2);
  PoseInterval side{read_number(ends[0], draft, dimension), read_number(ends[1], draft, dimension), true};
  if (side.begin.value() == side.end.value())
    at.fail({.expected = "two different numbers, or one number without brackets", .found = "the same twice"});
  return side;
}

void read_tool_box(const SpecCursor& at, StudyBuilder& draft, PoseBox& box) {
  box.tool = true;
  const std::size_t count = draft.planar() ? 2 : 3;
  for (const SpecCursor& item :
       at.items(draft.planar() ? "two stretches [[x0, x1], [y0, y1]]" : "three stretches", count))
    box.sides.push_back(read_side(item, draft, dimension::length));
}

void read_joints_box(const SpecCursor& at, StudyBuilder& draft, PoseBox& box) {
  bool right = true;
  for (const Member& member : list_members(at, "a mapping of joint coordinates to stretches {J1: [0, 1]}")) {
    const auto read = [&] {
      const CoordinateId coordinate = find_coordinate(member.key, member.name, draft);
      const CoordinateKind kind = draft.mechanism().coordinates[static_cast<std::size_t>(coordinate)].kind;
      box.sides.push_back(read_side(member.value, draft, dimension_of(kind)));
      box.joints.push_back(coordinate);
    };
    right = at.problems().collect(read) && right;
  }
  if (!right) throw CascadingError();
  if (at.node().items.empty()) at.fail_expected("stretches of at least one joint coordinate");
}

void read_samples(StudyBuilder& draft, const SpecCursor& at, PoseBox& box) {
  const SpecCursor& c = box.samples ? *box.samples : at;
  std::vector<PoseInterval*> open;
  for (PoseInterval& side : box.sides)
    if (side.open) open.push_back(&side);
  if (open.empty()) at.fail({.expected = "a stretch [from, to] of something", .found = "one pose"});
  for (PoseInterval* side : open) side->samples = default_workspace_poses;
  if (box.samples && c.is_list()) {
    const auto items = c.items("one number of samples a stretch", open.size());
    for (std::size_t i = 0; i < items.size(); ++i)
      open[i]->samples = read_integer(items[i], draft, 2, max_workspace_poses);
  } else if (box.samples) {
    const long all = read_integer(c, draft, 2, max_workspace_poses);
    for (PoseInterval* side : open) side->samples = all;
  }
  double poses = 1;
  for (const PoseInterval* side : open) poses *= static_cast<double>(side->samples);
  if (poses > static_cast<double>(max_workspace_poses))
    c.fail({.expected = fmt::format("at most {} poses", max_workspace_poses), .found = fmt::format("{:.9g}", poses)});
}

/// Places on the grid, one side's number each, every one beside the one before it.
std::vector<std::vector<long>> serpentine_grid(const std::vector<PoseInterval>& sides) {
  std::vector<std::vector<long>> places{{}};
  for (const PoseInterval& side : sides) {
    std::vector<std::vector<long>> longer;
    for (std::size_t p = 0; p < places.size(); ++p)
      for (long k = 0; k < side.samples; ++k) {
        longer.push_back(places[p]);
        longer.back().push_back(p % 2 == 0 ? k : side.samples - 1 - k);
      }
    places = std::move(longer);
  }
  return places;
}

PoseTargetOf<Expression> pose_at(const PoseBox& box, const std::vector<long>& place) {
  PoseTargetOf<Expression> pose;
  const auto value = [&](std::size_t s) { return box.sides[s].at(place[s]); };
  for (std::size_t s = 0; s < box.joints.size(); ++s) pose.joints.push_back({box.joints[s], value(s)});
  if (!box.joints.empty()) return pose;
  const std::size_t positions = box.sides.size() - (box.angle ? 1 : 0);
  pose.tool = Vector3E::Zero();
  for (std::size_t s = 0; s < positions; ++s) (*pose.tool)[static_cast<Eigen::Index>(s)] = value(s);
  if (box.angle) pose.angle = value(positions);
  pose.orientation = box.orientation;
  return pose;
}

/// To and fro, with two stops at every turn, and one more at the end: each pose then weighs the same.
std::vector<PoseTargetOf<Expression>> list_stops(const PoseBox& box) {
  std::vector<PoseTargetOf<Expression>> once, stops;
  for (const auto& place : serpentine_grid(box.sides)) once.push_back(pose_at(box, place));
  const auto count = static_cast<long>(once.size());
  const long rounds = std::max(1L, (min_time_steps + 2 * count - 1) / (2 * count));
  for (long round = 0; round < rounds; ++round) {
    stops.insert(stops.end(), once.begin(), once.end());
    stops.insert(stops.end(), once.rbegin(), once.rend());
  }
  stops.push_back(once.front());
  return stops;
}

/// Resting at every sample: the law's rate and acceleration vanish at both ends of each leg.
TrajectoryOf<Expression> stopping_at(const std::vector<PoseTargetOf<Expression>>& stops, DriveKind drive) {
  TrajectoryOf<Expression> trajectory;
  trajectory.name = workspace_name;
  trajectory.law.kind = MotionLawKind::polynomial_345;
  trajectory.drive = drive;
  trajectory.from = stops.front();
  trajectory.to = stops.back();
  const std::size_t legs = stops.size() - 1;
  trajectory.duration = static_cast<double>(legs);
  trajectory.samples = static_cast<long>(stops.size());
  WaypointPathOf<Expression> path;
  path.points.assign(stops.begin() + 1, stops.end() - 1);
  for (std::size_t k = 1; k < legs; ++k)
    path.fractions.emplace_back(static_cast<double>(k) / static_cast<double>(legs));
  trajectory.path = std::move(path);
  return trajectory;
}

/// The box as the spec has it.
PoseBox read_box(const SpecCursor& at, StudyBuilder& draft) {
  PoseBox box;
  std::optional<SpecCursor> tool, joints, angle;
  const auto keep = [](std::optional<SpecCursor>& slot) { return [&slot](const SpecCursor& c) { slot = c; }; };
  std::vector<Field> fields{{"tool", Presence::optional, keep(tool)},
                            {"joints", Presence::optional, keep(joints)},
                            {"samples", Presence::optional, keep(box.samples)}};
  const auto turned = [&](Matrix3E (*read)(const SpecCursor&, StudyBuilder&)) {
    return [&box, &draft, read](const SpecCursor& c) {
      if (box.orientation) c.fail({.expected = "'rpy' or 'quaternion'", .found = "both"});
      box.orientation = read(c, draft);
    };
  };
  if (draft.planar()) {
    fields.push_back({"angle", Presence::optional, keep(angle)});
  } else {
    fields.push_back({"rpy", Presence::optional, turned(read_rpy)});
    fields.push_back({"quaternion", Presence::optional, turned(read_quaternion)});
  }
  if (!read_fields(at, "a workspace {tool: [[x0, x1], [y0, y1]]} or {joints: {J1: [a, b]}}", fields))
    throw CascadingError();
  if (tool && joints) joints->fail({.expected = "'tool' or 'joints'", .found = "both"});
  if (!tool && !joints) at.fail_missing({"tool", "joints"});
  if (joints && (angle || box.orientation)) at.fail({.expected = "no direction of the tool beside 'joints'"});
  if (tool && !draft.mechanism().tool)
    tool->fail_unless_uncertain("tool", {.expected = "a spec with a tool ('tool: body.point')", .found = "none"});
  if (tool) read_tool_box(*tool, draft, box);
  if (angle) box.sides.push_back(read_side(*angle, draft, dimension::angle));
  box.angle = angle.has_value();
  if (joints) read_joints_box(*joints, draft, box);
  read_samples(draft, at, box);
  return box;
}

}  // namespace

void read_workspace(const SpecCursor& at, StudyBuilder& draft) {
  for (const auto& trajectory : draft.trajectories())
    if (trajectory.name == workspace_name)
      at.fail({.expected = "another name of the trajectory 'workspace'", .found = "a workspace beside it"});
  require_permanent_payloads(at, "no workspace, whose poses have no time", draft);
  const PoseBox box = read_box(at, draft);
  draft.trajectories().push_back(stopping_at(list_stops(box), box.tool ? DriveKind::tool : DriveKind::joints));
}

}  // namespace balance::specification
