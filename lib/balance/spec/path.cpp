#include "balance/spec/path.hpp"

#include "balance/spec/directions.hpp"
#include "balance/spec/pose.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace balance::specification {

namespace {

bool has_key(const SpecCursor& at, const char* name) {
  if (!at.is_map()) return false;
  for (const YamlNode& key : at.node().keys)
    if (key.text == name) return true;
  return false;
}

/// The point that the drive moves, where the spec gives it: the centre of mass of a pose of joints is known only later.
std::optional<Vector3E> moved_point(const PoseTargetOf<Expression>& pose, DriveKind drive) {
  return drive == DriveKind::tool ? pose.tool : pose.com;
}

void require_moved_point(const SpecCursor& at, const TrajectoryOf<Expression>& trajectory) {
  if (trajectory.drive == DriveKind::joints)
    at.fail({.expected = "a path for joint coordinates (line, waypoints, table, file)",
             .found = "one for a point in the plane or in space"});
}

CirclePathOf<Expression> read_circle(const SpecCursor& at, StudyBuilder& draft,
                                     const TrajectoryOf<Expression>& trajectory) {
  require_moved_point(at, trajectory);
  CirclePathOf<Expression> circle;
  std::optional<SpecCursor> centre, angle;
  const auto read_centre = [&](const SpecCursor& c) {
    if (centre) c.fail({.expected = "'centre' once", .found = "it again in another spelling"});
    centre = c;
    circle.centre = read_vector(c, draft, dimension::length);
  };
  const auto read_angle = [&](const SpecCursor& c, const Expression& value) {
    if (angle) c.fail({.expected = "'angle' or 'turns'", .found = "both"});
    angle = c;
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
  if (!centre) at.fail_missing({"centre"});
  if (!angle) at.fail_missing({"angle", "turns"});
  if (const auto start = moved_point(trajectory.from, trajectory.drive)) {
    const Vector3 radius = values_of(*start) - values_of(circle.centre);
    if (!(radius.cross(values_of(circle.normal)).norm() > 0))
      centre->fail({.expected = "a centre away from where the motion starts", .found = "the start itself"});
  }
  return circle;
}

ArcPathOf<Expression> read_arc(const SpecCursor& at, StudyBuilder& draft, const TrajectoryOf<Expression>& trajectory) {
  require_moved_point(at, trajectory);
  ArcPathOf<Expression> arc;
  std::optional<SpecCursor> via;
  const bool read = read_fields(at, "an arc {via}", {{"via", Presence::required, [&](const SpecCursor& c) {
                                                        via = c;
                                                        arc.via = read_vector(c, draft, dimension::length);
                                                      }}});
  const auto from = moved_point(trajectory.from, trajectory.drive);
  const auto to = moved_point(trajectory.to, trajectory.drive);
  if (!read || !from || !to) return arc;
  const Vector3 a = values_of(arc.via) - values_of(*from), b = values_of(*to) - values_of(*from);
  // A radius above a million chords is a line in all but name.
  if (!(a.cross(b).norm() > 1e-6 * a.norm() * b.norm()))
    via->fail({.expected = "a point off the line from start to end", .found = "one on it"});
  return arc;
}

void read_times(const SpecCursor& at, StudyBuilder& draft, const TrajectoryOf<Expression>& trajectory,
                WaypointPathOf<Expression>& path) {
  if (is_mechanism_dependent(trajectory.law.kind))
    at.fail({.expected = "no 'times' with a law that is searched for: it decides when waypoints are passed"});
  const auto times = at.items("a list of times");
  if (times.size() != path.points.size())
    at.fail({.expected = fmt::format("a list of {}, one time for each waypoint", path.points.size()),
             .found = fmt::format("{}", times.size())});
  double before = 0;
  read_each(times, [&](const SpecCursor& item) {
    const Expression at_point = read_number(item, draft, dimension::time);
    const double time = at_point.value(), duration = trajectory.duration.value();
    if (!(time > before && time < duration))
      item.fail({.expected = fmt::format("increasing times between 0 and the duration ({:.9g} s)", duration),
                 .found = fmt::format("{:.9g} s", time)});
    before = time;
    path.fractions.push_back(at_point / trajectory.duration);
  });
}

WaypointPathOf<Expression> read_waypoints(const SpecCursor& at, StudyBuilder& draft,
                                          const TrajectoryOf<Expression>& trajectory) {
  WaypointPathOf<Expression> path;
  const DriveRequirements needs{trajectory.drive, trajectory.components};
  std::optional<SpecCursor> times;
  const bool read = read_fields(at, "waypoints",
                                {{"waypoints", Presence::required,
                                  [&](const SpecCursor& c) {
                                    read_each(c.items("a list of poses"), [&](const SpecCursor& item) {
                                      PoseTargetOf<Expression> pose;
                                      if (!draft.problems.collect([&] { pose = read_pose(item, draft); }))
                                        throw CascadingError();
                                      check_pose(item, pose, needs, draft);
                                      match_pose(item, pose, trajectory.from, trajectory.drive, draft);
                                      path.points.push_back(pose);
                                    });
                                    if (c.node().items.empty()) c.fail_expected("at least one pose");
                                  }},
                                 {"blend", Presence::optional,
                                  [&](const SpecCursor& c) {
                                    path.spline = c.read_choice("how to pass the waypoints", {"rest", "spline"}) == 1;
                                  }},
                                 {"times", Presence::optional, [&](const SpecCursor& c) { times = c; }}});
  if (read && times) read_times(*times, draft, trajectory, path);
  return path;
}

}  // namespace

bool is_corridor(const SpecCursor& path) { return has_key(path, "corridor"); }

bool is_table(const SpecCursor& path) { return has_key(path, "table") || has_key(path, "file"); }

bool is_circle(const SpecCursor& path) { return has_key(corridor_centreline(path), "circle"); }

bool has_end_pose(const SpecCursor* path) { return path == nullptr || !is_circle(*path); }

void read_path(const SpecCursor& at, StudyBuilder& draft, TrajectoryOf<Expression>& trajectory) {
  const std::string what =
      "a path: line, {circle: …}, {arc: …}, {waypoints: …}, {table: …}, {file: …} or {corridor: …}";
  if (at.is_scalar() && at.node().text == "line") return;
  if (!at.is_map()) at.fail_expected(what);
  if (has_key(at, "waypoints")) {
    trajectory.path = read_waypoints(at, draft, trajectory);
    return;
  }
  std::optional<SpecCursor> table, columns, file, circle, arc, corridor;
  const auto keep = [](std::optional<SpecCursor>& slot) { return [&slot](const SpecCursor& c) { slot = c; }; };
  const bool read = read_fields(at, what,
                                {{"circle", Presence::optional, keep(circle)},
                                 {"arc", Presence::optional, keep(arc)},
                                 {"waypoints", Presence::optional, [](const SpecCursor&) {}},
                                 {"table", Presence::optional, keep(table)},
                                 {"columns", Presence::optional, keep(columns)},
                                 {"file", Presence::optional, keep(file)},
                                 {"corridor", Presence::optional, keep(corridor)}});
  if (!read) return;
  const auto given = {&circle, &arc, &table, &file, &corridor};
  if (std::count_if(given.begin(), given.end(), [](const auto* path) { return path->has_value(); }) != 1)
    at.fail_expected(what);
  if (columns && !table) columns->fail({.expected = "no 'columns' without 'table'"});
  if (circle) trajectory.path = read_circle(*circle, draft, trajectory);
  if (arc) trajectory.path = read_arc(*arc, draft, trajectory);
  if (table) read_table_path(*table, columns, draft, trajectory);
  if (file) read_file_path(*file, draft, trajectory);
  if (corridor) read_corridor(*corridor, draft, trajectory);
}

}  // namespace balance::specification
