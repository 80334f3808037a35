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

/// One coordinate of the box: an interval, or a value shared by all poses.
struct PoseInterval {
  Expression begin, end;
  bool is_interval = false;  ///< else one value
  long samples = 1;

  Expression at(long k) const {
    if (!is_interval) return begin;
    return begin + (end - begin) * (static_cast<double>(k) / static_cast<double>(samples - 1));
  }
};

/// The quantities of a pose, and the sides in that order.
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
  for (const SpecCursor& item : at.items(draft.planar() ? "two ranges [[x0, x1], [y0, y1]]" : "three ranges", count))
    box.sides.push_back(read_side(item, draft, dimension::length));
}

void read_joints_box(const SpecCursor& at, StudyBuilder& draft, PoseBox& box) {
  bool is_valid = true;
  for (const Member& member : list_members(at, "a mapping of joint coordinates to ranges {J1: [0, 1]}")) {
    const auto read = [&] {
      const CoordinateId coordinate = find_coordinate(member.key, member.name, draft);
      const CoordinateKind kind = draft.mechanism().coordinates[static_cast<std::size_t>(coordinate)].kind;
      box.sides.push_back(read_side(member.value, draft, dimension_of(kind)));
      box.joints.push_back(coordinate);
    };
    is_valid = at.problems().collect(read) && is_valid;
  }
  if (!is_valid) throw CascadingError();
  if (at.node().items.empty()) at.fail_expected("a range of at least one joint coordinate");
}

void read_samples(StudyBuilder& draft, const SpecCursor& at, PoseBox& box) {
  const SpecCursor& c = box.samples ? *box.samples : at;
  std::vector<PoseInterval*> intervals;
  for (PoseInterval& side : box.sides)
    if (side.is_interval) intervals.push_back(&side);
  if (intervals.empty()) at.fail({.expected = "at least one range [from, to]", .found = "a single pose"});
  for (PoseInterval* side : intervals) side->samples = default_workspace_poses;
  if (box.samples && c.is_list()) {
    const auto items = c.items("a number of samples for each range", intervals.size());
    for (std::size_t i = 0; i < items.size(); ++i)
      intervals[i]->samples = read_integer(items[i], draft, 2, max_workspace_poses);
  } else if (box.samples) {
    const long samples = read_integer(c, draft, 2, max_workspace_poses);
    for (PoseInterval* side : intervals) side->samples = samples;
  }
  double poses = 1;
  for (const PoseInterval* side : intervals) poses *= static_cast<double>(side->samples);
  if (poses > static_cast<double>(max_workspace_poses))
    c.fail({.expected = fmt::format("at most {} poses", max_workspace_poses), .found = fmt::format("{:.9g}", poses)});
}

/// Points of the grid, one index per side, each adjacent to the one before it.
std::vector<std::vector<long>> serpentine_grid(const std::vector<PoseInterval>& sides) {
  std::vector<std::vector<long>> grid{{}};
  for (const PoseInterval& side : sides) {
    std::vector<std::vector<long>> extended;
    for (std::size_t p = 0; p < grid.size(); ++p)
      for (long k = 0; k < side.samples; ++k) {
        extended.push_back(grid[p]);
        extended.back().push_back(p % 2 == 0 ? k : side.samples - 1 - k);
      }
    grid = std::move(extended);
  }
  return grid;
}

trajectory::PoseTargetOf<Expression> pose_at(const PoseBox& box, const std::vector<long>& indices) {
  trajectory::PoseTargetOf<Expression> pose;
  const auto value = [&](std::size_t s) { return box.sides[s].at(indices[s]); };
  for (std::size_t s = 0; s < box.joints.size(); ++s) pose.joints.push_back({box.joints[s], value(s)});
  if (!box.joints.empty()) return pose;
  const std::size_t positions = box.sides.size() - (box.angle ? 1 : 0);
  pose.tool = Vector3E::Zero();
  for (std::size_t s = 0; s < positions; ++s) (*pose.tool)[static_cast<Eigen::Index>(s)] = value(s);
  if (box.angle) pose.angle = value(positions);
  pose.orientation = box.orientation;
  return pose;
}

/// Back and forth, with two stops at every turning point and one more at the end: each pose then has the same weight.
std::vector<trajectory::PoseTargetOf<Expression>> list_stops(const PoseBox& box) {
  std::vector<trajectory::PoseTargetOf<Expression>> poses, stops;
  for (const auto& indices : serpentine_grid(box.sides)) poses.push_back(pose_at(box, indices));
  const auto count = static_cast<long>(poses.size());
  const long rounds = std::max(1L, (trajectory::min_time_steps + 2 * count - 1) / (2 * count));
  for (long round = 0; round < rounds; ++round) {
    stops.insert(stops.end(), poses.begin(), poses.end());
    stops.insert(stops.end(), poses.rbegin(), poses.rend());
  }
  stops.push_back(poses.front());
  return stops;
}

/// Rests at every sample: the law's rate and acceleration vanish at both ends of each leg.
TrajectoryOf<Expression> make_stop_trajectory(const std::vector<trajectory::PoseTargetOf<Expression>>& stops,
                                              DriveKind drive) {
  TrajectoryOf<Expression> trajectory;
  trajectory.name = workspace_name;
  trajectory.law.kind = MotionLawKind::polynomial_345;
  trajectory.drive = drive;
  trajectory.from = stops.front();
  trajectory.to = stops.back();
  const std::size_t legs = stops.size() - 1;
  trajectory.duration = static_cast<double>(legs);
  trajectory.samples = static_cast<long>(stops.size());
  trajectory::WaypointPathOf<Expression> path;
  path.points.assign(stops.begin() + 1, stops.end() - 1);
  for (std::size_t k = 1; k < legs; ++k)
    path.fractions.emplace_back(static_cast<double>(k) / static_cast<double>(legs));
  trajectory.path = std::move(path);
  return trajectory;
}

/// Reads the box from the spec.
PoseBox read_box(const SpecCursor& at, StudyBuilder& draft) {
  PoseBox box;
  std::optional<SpecCursor> tool_entry, joints_entry, angle_entry;
  const auto store_in = [](std::optional<SpecCursor>& slot) { return [&slot](const SpecCursor& c) { slot = c; }; };
  std::vector<Field> fields{{"tool", Presence::optional, store_in(tool_entry)},
                            {"joints", Presence::optional, store_in(joints_entry)},
                            {"samples", Presence::optional, store_in(box.samples)}};
  const auto read_orientation = [&](Matrix3E (*read)(const SpecCursor&, StudyBuilder&)) {
    return [&box, &draft, read](const SpecCursor& c) {
      if (box.orientation) c.fail({.expected = "'rpy' or 'quaternion'", .found = "both"});
      box.orientation = read(c, draft);
    };
  };
  if (draft.planar()) {
    fields.push_back({"angle", Presence::optional, store_in(angle_entry)});
  } else {
    fields.push_back({"rpy", Presence::optional, read_orientation(read_rpy)});
    fields.push_back({"quaternion", Presence::optional, read_orientation(read_quaternion)});
  }
  if (!read_fields(at, "a workspace {tool: [[x0, x1], [y0, y1]]} or {joints: {J1: [a, b]}}", fields))
    throw CascadingError();
  if (tool_entry && joints_entry) joints_entry->fail({.expected = "'tool' or 'joints'", .found = "both"});
  if (!tool_entry && !joints_entry) at.fail_missing({"tool", "joints"});
  if (joints_entry && (angle_entry || box.orientation)) at.fail({.expected = "no direction of the tool with 'joints'"});
  if (tool_entry && !draft.mechanism().tool)
    tool_entry->fail_unless_uncertain("tool", {.expected = "a spec with a tool ('tool: body.point')", .found = "none"});
  if (tool_entry) read_tool_box(*tool_entry, draft, box);
  if (angle_entry) box.sides.push_back(read_side(*angle_entry, draft, dimension::angle));
  box.angle = angle_entry.has_value();
  if (joints_entry) read_joints_box(*joints_entry, draft, box);
  read_samples(draft, at, box);
  return box;
}

}  // namespace

void read_workspace(const SpecCursor& at, StudyBuilder& draft) {
  for (const auto& trajectory : draft.trajectories())
    if (trajectory.name == workspace_name)
      at.fail({.expected = "another name for the trajectory 'workspace'", .found = "a workspace as well"});
  require_permanent_payloads(at, "no workspace, whose poses have no time", draft);
  const PoseBox box = read_box(at, draft);
  draft.trajectories().push_back(make_stop_trajectory(list_stops(box), box.tool ? DriveKind::tool : DriveKind::joints));
}

}  // namespace balance::specification
