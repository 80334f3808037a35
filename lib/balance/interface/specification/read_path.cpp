#include "balance/interface/specification/read_path.hpp"

#include "balance/foundation/base/spelling.hpp"
#include "balance/interface/specification/part_insertion.hpp"
#include "balance/interface/specification/read_pose.hpp"
#include "balance/interface/specification/spec_table.hpp"
#include "balance/interface/specification/study_builder.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <numeric>

namespace balance::specification {

using trajectory::Component;

namespace {

constexpr int max_corridor_knots = 100;
constexpr int max_corridor_starts = 100;

/// Dimension of the space of the path; if joints are driven, their coordinates are its axes.
Dimension width_dimension(const SpecCursor& at, const TrajectoryOf<Expression>& trajectory, const StudyBuilder& draft) {
  if (trajectory.drive != DriveKind::joints) return dimension::length;
  bool has_angle = false, has_length = false;
  for (const auto& value : trajectory.from.joints) {
    const auto c = static_cast<std::size_t>(value.coordinate);
    (draft.mechanism().coordinates[c].kind == CoordinateKind::angle ? has_angle : has_length) = true;
  }
  if (has_angle && has_length)
    at.fail({.expected =
                 "no corridor with a drive of both turning and sliding joints, which share no measure of distance"});
  if (trajectory.from.joints.size() == 1)
    at.fail({.expected = "a drive of at least two joints: one alone leaves no room beside its path"});
  return has_length ? dimension::length : dimension::angle;
}

/// Only a path without corners has a defined distance to every side.
void read_centreline(const SpecCursor& at, StudyBuilder& draft, TrajectoryOf<Expression>& trajectory) {
  read_path(at, draft, trajectory);
  if (trajectory.corridor || std::holds_alternative<trajectory::WaypointPathOf<Expression>>(trajectory.path) ||
      std::holds_alternative<trajectory::TablePathOf<Expression>>(trajectory.path))
    at.fail({.expected = "line, {circle: …} or {arc: …}: a corridor needs a path without corners and bends of its own",
             .found = "another path"});
}

/// The search must be free to choose the motion: nothing else may depend on where the mechanism is at a given time.
void check_corridor_trajectory(const SpecCursor& at, const TrajectoryOf<Expression>& trajectory) {
  const auto& components = trajectory.components;
  const auto turns = [](Component c) { return c >= Component::rx; };
  if (!components.empty() && std::count_if(components.begin(), components.end(), std::not_fn(turns)) < 2)
    at.fail(
        {.expected = "at least two coordinates of a point among the components: one leaves no room beside its path"});
  if (trajectory.law.kind == MotionLawKind::constant_momentum)
    at.fail({.expected = "no corridor with the law 'steady-momentum', which leaves nothing to minimize"});
  if (trajectory.start_speed.value() != 0 || trajectory.end_speed.value() != 0)
    at.fail({.expected = "no corridor with 'speeds': the motion starts and ends at rest"});
  for (const auto& task : trajectory.secondary_tasks) {
    const auto* spline = std::get_if<trajectory::SplineTaskOf<Expression>>(&task.kind);
    if (spline == nullptr || spline->over_time)
      at.fail({.expected = "no corridor with a spline over time or a kept momentum"});
  }
}

double radius_of(const TrajectoryOf<Expression>& trajectory) {
  const auto* circle = std::get_if<trajectory::CirclePathOf<Expression>>(&trajectory.path);
  const auto& start = trajectory.drive == DriveKind::tool ? trajectory.from.tool : trajectory.from.com;
  if (circle == nullptr || !start) return std::numeric_limits<double>::infinity();
  const Vector3 outward = values_of(*start) - values_of(circle->centre), axis = values_of(circle->normal).normalized();
  return (outward - outward.dot(axis) * axis).norm();
}

}  // namespace

SpecCursor corridor_centreline(const SpecCursor& path) {
  const auto find_value = [](const SpecCursor& map, const std::string& name) -> std::optional<SpecCursor> {
    const YamlNode* value = find_entry(map.node(), name);
    if (value == nullptr) return std::nullopt;
    return SpecCursor(*value, map.path() + "." + name, map.problems());
  };
  const auto corridor_entry = find_value(path, "corridor");
  const auto along_entry = corridor_entry ? find_value(*corridor_entry, "along") : std::nullopt;
  return along_entry ? *along_entry : path;
}

void read_corridor(const SpecCursor& at, StudyBuilder& draft, TrajectoryOf<Expression>& trajectory) {
  std::optional<SpecCursor> along_entry, width_entry;
  trajectory::CorridorOf<Expression> corridor;
  const bool read = read_fields(at, "a corridor {along, width}",
                                {{"along", Presence::required, [&](const SpecCursor& c) { along_entry = c; }},
                                 {"width", Presence::required, [&](const SpecCursor& c) { width_entry = c; }},
                                 {"knots", Presence::optional,
                                  [&](const SpecCursor& c) {
                                    corridor.inner_knots =
                                        static_cast<int>(read_integer(c, draft, 1, max_corridor_knots));
                                  }},
                                 {"starts", Presence::optional, [&](const SpecCursor& c) {
                                    corridor.starts = static_cast<int>(read_integer(c, draft, 1, max_corridor_starts));
                                  }}});
  if (!read) return;
  check_corridor_trajectory(at, trajectory);
  const Dimension dimension = width_dimension(at, trajectory, draft);
  if (!width_entry->is_scalar()) width_entry->fail_expected("a number or an expression");
  corridor.width = read_number(*width_entry, draft, dimension, SignConstraint::positive);
  read_centreline(*along_entry, draft, trajectory);
  if (const double radius = radius_of(trajectory); !(corridor.width.value() < radius))
    width_entry->fail({.expected = fmt::format("a width less than the circle's radius ({:.6g} m)", radius),
                       .found = fmt::format("{:.6g} m", corridor.width.value())});
  trajectory.corridor = std::move(corridor);
}

namespace {

/// The point that the drive moves, if the spec gives it: the centre of mass of a pose given by
/// joints is known only later.
std::optional<Vector3E> moved_point(const trajectory::PoseTargetOf<Expression>& pose, DriveKind drive) {
  return drive == DriveKind::tool ? pose.tool : pose.com;
}

void require_moved_point(const SpecCursor& at, const TrajectoryOf<Expression>& trajectory) {
  if (trajectory.drive == DriveKind::joints)
    at.fail({.expected = "a path for joint coordinates (line, waypoints, table, file)",
             .found = "one for a point in the plane or in space"});
}

trajectory::CirclePathOf<Expression> read_circle(const SpecCursor& at, StudyBuilder& draft,
                                                 const TrajectoryOf<Expression>& trajectory) {
  require_moved_point(at, trajectory);
  trajectory::CirclePathOf<Expression> circle;
  std::optional<SpecCursor> centre_entry, angle_entry;
  const auto read_centre = [&](const SpecCursor& c) {
    if (centre_entry) c.fail({.expected = "'centre' only once", .found = "it again in another spelling"});
    centre_entry = c;
    circle.centre = read_vector(c, draft, dimension::length);
  };
  const auto read_angle = [&](const SpecCursor& c, const Expression& value) {
    if (angle_entry) c.fail({.expected = "'angle' or 'turns'", .found = "both"});
    angle_entry = c;
    circle.angle = value;
    if (value.value() == 0 && c.is_scalar()) c.fail({.expected = "an angle other than 0", .found = "0"});
  };
  std::vector<Field> fields{{"centre", Presence::optional, read_centre},
                            {"center", Presence::optional, read_centre},
                            {"angle", Presence::optional,
                             [&](const SpecCursor& c) { read_angle(c, read_number(c, draft, dimension::angle)); }},
                            {"turns", Presence::optional, [&](const SpecCursor& c) {
                               read_angle(c, 2.0 * std::numbers::pi * read_number(c, draft, dimension::dimensionless));
                             }}};
  if (!draft.planar())
    fields.push_back(
        {"normal", Presence::required, [&](const SpecCursor& c) { circle.normal = read_direction(c, draft); }});
  if (!read_fields(at, "a circle {centre, angle or turns}", fields)) return circle;
  if (!centre_entry) at.fail_missing({"centre"});
  if (!angle_entry) at.fail_missing({"angle", "turns"});
  if (const auto start = moved_point(trajectory.from, trajectory.drive)) {
    const Vector3 radius = values_of(*start) - values_of(circle.centre);
    if (!(radius.cross(values_of(circle.normal)).norm() > 0))
      centre_entry->fail({.expected = "a centre away from where the motion starts", .found = "the start itself"});
  }
  return circle;
}

trajectory::ArcPathOf<Expression> read_arc(const SpecCursor& at, StudyBuilder& draft,
                                           const TrajectoryOf<Expression>& trajectory) {
  require_moved_point(at, trajectory);
  trajectory::ArcPathOf<Expression> arc;
  std::optional<SpecCursor> via_entry;
  const bool read = read_fields(at, "an arc {via}", {{"via", Presence::required, [&](const SpecCursor& c) {
                                                        via_entry = c;
                                                        arc.via = read_vector(c, draft, dimension::length);
                                                      }}});
  const auto from = moved_point(trajectory.from, trajectory.drive);
  const auto to = moved_point(trajectory.to, trajectory.drive);
  if (!read || !from || !to) return arc;
  const Vector3 a = values_of(arc.via) - values_of(*from), b = values_of(*to) - values_of(*from);
  // with a radius above a million chords it is practically a line
  if (!(a.cross(b).norm() > 1e-6 * a.norm() * b.norm()))
    via_entry->fail({.expected = "a point off the line from start to end", .found = "one on it"});
  return arc;
}

void read_times(const SpecCursor& at, StudyBuilder& draft, const TrajectoryOf<Expression>& trajectory,
                trajectory::WaypointPathOf<Expression>& path) {
  if (is_mechanism_dependent(trajectory.law.kind))
    at.fail({.expected = "no 'times' with a law that is searched for: it determines when waypoints are passed"});
  const auto times = at.items("a list of times");
  if (times.size() != path.points.size())
    at.fail({.expected = fmt::format("a list of {}, one time for each waypoint", path.points.size()),
             .found = fmt::format("{}", times.size())});
  double previous = 0;
  read_each(times, [&](const SpecCursor& item) {
    const Expression waypoint_time = read_number(item, draft, dimension::time);
    const double time = waypoint_time.value(), duration = trajectory.duration.value();
    if (!(time > previous && time < duration))
      item.fail({.expected = fmt::format("increasing times between 0 and the duration ({:.9g} s)", duration),
                 .found = fmt::format("{:.9g} s", time)});
    previous = time;
    path.fractions.push_back(waypoint_time / trajectory.duration);
  });
}

trajectory::WaypointPathOf<Expression> read_waypoints(const SpecCursor& at, StudyBuilder& draft,
                                                      const TrajectoryOf<Expression>& trajectory) {
  trajectory::WaypointPathOf<Expression> path;
  const DriveRequirements requirements{trajectory.drive, trajectory.components};
  std::optional<SpecCursor> times_entry;
  const bool read = read_fields(at, "waypoints",
                                {{"waypoints", Presence::required,
                                  [&](const SpecCursor& c) {
                                    read_each(c.items("a list of poses"), [&](const SpecCursor& item) {
                                      trajectory::PoseTargetOf<Expression> pose;
                                      if (!draft.problems.collect([&] { pose = read_pose(item, draft); }))
                                        throw CascadingError();
                                      check_pose(item, pose, requirements, draft);
                                      match_pose(item, pose, trajectory.from, trajectory.drive, draft);
                                      path.points.push_back(pose);
                                    });
                                    if (c.node().items.empty()) c.fail_expected("at least one pose");
                                  }},
                                 {"blend", Presence::optional,
                                  [&](const SpecCursor& c) {
                                    path.spline = c.read_choice("a way to pass the waypoints", {"rest", "spline"}) == 1;
                                  }},
                                 {"times", Presence::optional, [&](const SpecCursor& c) { times_entry = c; }}});
  if (read && times_entry) read_times(*times_entry, draft, trajectory, path);
  return path;
}

}  // namespace

bool is_corridor(const SpecCursor& path) { return path.has_entry("corridor"); }

bool is_table(const SpecCursor& path) { return path.has_entry("table") || path.has_entry("file"); }

bool is_circle(const SpecCursor& path) { return corridor_centreline(path).has_entry("circle"); }

bool has_end_pose(const SpecCursor* path) { return path == nullptr || !is_circle(*path); }

void read_path(const SpecCursor& at, StudyBuilder& draft, TrajectoryOf<Expression>& trajectory) {
  const std::string what =
      "a path: line, {circle: …}, {arc: …}, {waypoints: …}, {table: …}, {file: …} or {corridor: …}";
  if (at.is_scalar() && at.node().text == "line") return;
  if (!at.is_map()) at.fail_expected(what);
  if (at.has_entry("waypoints")) {
    trajectory.path = read_waypoints(at, draft, trajectory);
    return;
  }
  std::optional<SpecCursor> table_entry, columns_entry, file_entry, circle_entry, arc_entry, corridor_entry;
  const auto store_in = [](std::optional<SpecCursor>& slot) { return [&slot](const SpecCursor& c) { slot = c; }; };
  const bool read = read_fields(at, what,
                                {{"circle", Presence::optional, store_in(circle_entry)},
                                 {"arc", Presence::optional, store_in(arc_entry)},
                                 {"waypoints", Presence::optional, [](const SpecCursor&) {}},
                                 {"table", Presence::optional, store_in(table_entry)},
                                 {"columns", Presence::optional, store_in(columns_entry)},
                                 {"file", Presence::optional, store_in(file_entry)},
                                 {"corridor", Presence::optional, store_in(corridor_entry)}});
  if (!read) return;
  const auto entries = {&circle_entry, &arc_entry, &table_entry, &file_entry, &corridor_entry};
  if (std::count_if(entries.begin(), entries.end(), [](const auto* entry) { return entry->has_value(); }) != 1)
    at.fail_expected(what);
  if (columns_entry && !table_entry) columns_entry->fail({.expected = "no 'columns' without 'table'"});
  if (circle_entry) trajectory.path = read_circle(*circle_entry, draft, trajectory);
  if (arc_entry) trajectory.path = read_arc(*arc_entry, draft, trajectory);
  if (table_entry) read_table_path(*table_entry, columns_entry, draft, trajectory);
  if (file_entry) read_file_path(*file_entry, draft, trajectory);
  if (corridor_entry) read_corridor(*corridor_entry, draft, trajectory);
}

namespace {

/// Minimum for a spline.
constexpr std::size_t min_table_rows = 4;

constexpr Component space_components[]{Component::x,  Component::y,  Component::z,
                                       Component::rx, Component::ry, Component::rz};
constexpr Component plane_components[]{Component::x, Component::y, Component::rz};

Component component_at(int column, const StudyBuilder& draft) {
  const auto i = static_cast<std::size_t>(column);
  return draft.planar() ? plane_components[i] : space_components[i];
}

/// Columns that a table may have.
std::vector<TableColumn> possible_columns(const StudyBuilder& draft, DriveKind drive) {
  const bool planar = draft.planar();
  std::vector<TableColumn> columns;
  if (drive == DriveKind::joints) {
    for (const Coordinate& c : draft.mechanism().coordinates) columns.push_back({c.name, dimension_of(c.kind)});
    return columns;
  }
  columns = {{"x", dimension::length}, {"y", dimension::length}};
  if (!planar) columns.push_back({"z", dimension::length});
  if (drive == DriveKind::com) return columns;
  if (planar)
    columns.push_back({"angle", dimension::angle});
  else
    for (const char* name : {"rx", "ry", "rz"}) columns.push_back({name, dimension::angle});
  return columns;
}

/// The pose that one row of the table prescribes.
trajectory::PoseTargetOf<Expression> pose_of(const std::vector<Expression>& row, const std::vector<int>& columns,
                                             const StudyBuilder& draft, DriveKind drive) {
  trajectory::PoseTargetOf<Expression> pose;
  Vector3E position = Vector3E::Zero(), rotation = Vector3E::Zero();
  bool has_position = false, has_rotation = false;
  for (std::size_t i = 0; i < row.size(); ++i) {
    if (drive == DriveKind::joints) {
      pose.joints.push_back({columns[i], row[i]});
      continue;
    }
    const int component = static_cast<int>(component_at(columns[i], draft));
    (component < 3 ? has_position : has_rotation) = true;
    (component < 3 ? position : rotation)[component % 3] = row[i];
  }
  if (has_position) (drive == DriveKind::tool ? pose.tool : pose.com) = position;
  if (has_rotation && draft.planar())
    pose.angle = rotation[2];
  else if (has_rotation)
    pose.orientation = rotation_from_vector(rotation);
  return pose;
}

void assign_path_table(const SpecCursor& at, const TimeTable& table, StudyBuilder& draft,
                       TrajectoryOf<Expression>& trajectory) {
  if (table.time.size() < min_table_rows)
    at.fail(
        {.expected = fmt::format("at least {} rows", min_table_rows), .found = fmt::format("{}", table.time.size())});
  const auto possible = possible_columns(draft, trajectory.drive);
  if (trajectory.drive != DriveKind::joints) {
    std::vector<Component> components;
    for (const int column : table.columns) components.push_back(component_at(column, draft));
    if (!trajectory.components.empty() && trajectory.components != components)
      at.fail({.expected = fmt::format("the trajectory's {} components in their order", trajectory.components.size()),
               .found = fmt::format("{} columns", components.size())});
    trajectory.components = components;
  }
  trajectory.from = pose_of(table.values.front(), table.columns, draft, trajectory.drive);
  trajectory.to = pose_of(table.values.back(), table.columns, draft, trajectory.drive);
  trajectory.duration = table.time.back() - table.time.front();
  check_duration(at, trajectory.duration.value());
  trajectory.path = trajectory::TablePathOf<Expression>{table.time, table.values};
}

/// Sorts the columns in the order of Component, as the drive expects them. A file may have them in any order.
TimeTable sort_columns(TimeTable table) {
  std::vector<std::size_t> order(table.columns.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return table.columns[a] < table.columns[b]; });
  const auto rearrange = [&](auto& row) {
    auto copy = row;
    for (std::size_t i = 0; i < order.size(); ++i) row[i] = copy[order[i]];
  };
  for (auto& row : table.values) rearrange(row);
  rearrange(table.columns);
  return table;
}

/// The columns of a table in the spec that does not name them.
std::vector<int> default_columns(const SpecCursor& table, std::size_t count, const StudyBuilder& draft,
                                 const TrajectoryOf<Expression>& trajectory) {
  std::vector<int> columns;
  if (trajectory.drive == DriveKind::joints) {
    for (const auto& value : trajectory.from.joints) columns.push_back(value.coordinate);
    if (columns.empty()) columns.assign(draft.mechanism().actuators.begin(), draft.mechanism().actuators.end());
  } else if (!trajectory.components.empty()) {
    for (const Component c : trajectory.components) {
      const int component = static_cast<int>(c);
      columns.push_back(draft.planar() && c == Component::rz ? 2 : component);
    }
  } else {
    const std::size_t max_columns = possible_columns(draft, trajectory.drive).size();
    const bool positions_only = trajectory.drive == DriveKind::com || count < max_columns;
    columns.resize(positions_only ? (draft.planar() ? 2 : 3) : max_columns);
    std::iota(columns.begin(), columns.end(), 0);
  }
  if (columns.empty()) table.fail({.expected = "'columns: […]' to name the table's columns", .found = "none"});
  return columns;
}

std::vector<int> read_columns(const SpecCursor& at, const std::vector<TableColumn>& possible) {
  std::vector<std::string> names;
  for (const TableColumn& column : possible) names.push_back(column.name);
  std::vector<int> columns;
  read_each(at.items("a list of the columns after the time"), [&](const SpecCursor& item) {
    const int column = static_cast<int>(item.read_choice("a column", names));
    if (std::find(columns.begin(), columns.end(), column) != columns.end())
      item.fail({.expected = "each column only once", .found = fmt::format("{} again", item.describe_found())});
    columns.push_back(column);
  });
  if (columns.empty()) at.fail_expected("at least one column");
  return columns;
}

}  // namespace

void read_table_path(const SpecCursor& at, const std::optional<SpecCursor>& columns, StudyBuilder& draft,
                     TrajectoryOf<Expression>& trajectory) {
  const auto rows = at.items("a list of rows [time, …]");
  if (rows.empty()) at.fail_expected("a list of rows [time, …]");
  const auto possible = possible_columns(draft, trajectory.drive);
  const std::size_t count = rows[0].node().items.empty() ? 0 : rows[0].node().items.size() - 1;
  const std::vector<int> selection =
      columns ? read_columns(*columns, possible) : default_columns(at, count, draft, trajectory);
  std::vector<TableColumn> selected_columns;
  for (const int column : selection) selected_columns.push_back(possible[static_cast<std::size_t>(column)]);
  TimeTable table = read_inline_table(at, draft, selected_columns);
  table.columns = selection;
  const bool order_given = trajectory.drive == DriveKind::joints || !trajectory.components.empty();
  assign_path_table(at, order_given ? table : sort_columns(std::move(table)), draft, trajectory);
}

void read_file_path(const SpecCursor& file, StudyBuilder& draft, TrajectoryOf<Expression>& trajectory) {
  const auto possible = possible_columns(draft, trajectory.drive);
  TimeTable table = read_table_file(file, draft, possible);
  assign_path_table(file, sort_columns(std::move(table)), draft, trajectory);
}

}  // namespace balance::specification
