#include "balance/spec/path.hpp"

#include "balance/spec/directions.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <limits>

namespace balance::specification {

namespace {

constexpr int max_corridor_knots = 100;
constexpr int max_corridor_starts = 100;

/// Of the space that the path lies in: joint coordinates are its axes where joints are driven.
Dimension width_dimension(const SpecCursor& at, const TrajectoryOf<Expression>& trajectory, const StudyBuilder& draft) {
  if (trajectory.drive != DriveKind::joints) return dimension::length;
  bool turns = false, slides = false;
  for (const auto& value : trajectory.from.joints) {
    const auto c = static_cast<std::size_t>(value.coordinate);
    (draft.mechanism().coordinates[c].kind == CoordinateKind::angle ? turns : slides) = true;
  }
  if (turns && slides)
    at.fail({.expected = "no corridor with a drive of turning and sliding joints, which have no distance in common"});
  if (trajectory.from.joints.size() == 1)
    at.fail({.expected = "a drive of at least two joints: one alone leaves no room beside its path"});
  return slides ? dimension::length : dimension::angle;
}

/// Only of a path without corners a distance to every side is known.
void read_centreline(const SpecCursor& at, StudyBuilder& draft, TrajectoryOf<Expression>& trajectory) {
  read_path(at, draft, trajectory);
  if (trajectory.corridor || std::holds_alternative<WaypointPathOf<Expression>>(trajectory.path) ||
      std::holds_alternative<TablePathOf<Expression>>(trajectory.path))
    at.fail({.expected = "line, {circle: …} or {arc: …}: a corridor needs a path without corners and bends of its own",
             .found = "another path"});
}

/// What a law leaves open must be left to the search: nothing beside it depends on where the mechanism is when.
void check_corridor_trajectory(const SpecCursor& at, const TrajectoryOf<Expression>& trajectory) {
  const auto& components = trajectory.components;
  const auto turns = [](Component c) { return c >= Component::rx; };
  if (!components.empty() && std::count_if(components.begin(), components.end(), std::not_fn(turns)) < 2)
    at.fail(
        {.expected = "at least two coordinates of a point among the components: one leaves no room beside its path"});
  if (trajectory.law.kind == MotionLawKind::constant_momentum)
    at.fail({.expected = "no corridor with the law 'steady-momentum', which leaves nothing to be made least"});
  if (trajectory.start_speed.value() != 0 || trajectory.end_speed.value() != 0)
    at.fail({.expected = "no corridor beside 'speeds': the motion starts and ends at rest"});
  for (const auto& course : trajectory.secondary_tasks) {
    const auto* spline = std::get_if<SplineTaskOf<Expression>>(&course.kind);
    if (spline == nullptr || spline->over_time)
      at.fail({.expected = "no corridor beside a spline over time or a kept momentum"});
  }
}

double radius_of(const TrajectoryOf<Expression>& trajectory) {
  const auto* circle = std::get_if<CirclePathOf<Expression>>(&trajectory.path);
  const auto& start = trajectory.drive == DriveKind::tool ? trajectory.from.tool : trajectory.from.com;
  if (circle == nullptr || !start) return std::numeric_limits<double>::infinity();
  const Vector3 outward = values_of(*start) - values_of(circle->centre), axis = values_of(circle->normal).normalized();
  return (outward - outward.dot(axis) * axis).norm();
}

}  // namespace

SpecCursor corridor_centreline(const SpecCursor& path) {
  const auto member = [](const SpecCursor& map, const std::string& name) -> std::optional<SpecCursor> {
    if (!map.is_map()) return std::nullopt;
    const YamlNode& node = map.node();
    for (std::size_t i = 0; i < node.keys.size() && i < node.items.size(); ++i)
      if (node.keys[i].text == name) return SpecCursor(node.items[i], map.path() + "." + name, map.problems());
    return std::nullopt;
  };
  const auto corridor = member(path, "corridor");
  const auto along = corridor ? member(*corridor, "along") : std::nullopt;
  return along ? *along : path;
}

void read_corridor(const SpecCursor& at, StudyBuilder& draft, TrajectoryOf<Expression>& trajectory) {
  std::optional<SpecCursor> along, width;
  CorridorOf<Expression> corridor;
  const bool read = read_fields(at, "a corridor {along, width}",
                                {{"along", Presence::required, [&](const SpecCursor& c) { along = c; }},
                                 {"width", Presence::required, [&](const SpecCursor& c) { width = c; }},
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
  if (!width->is_scalar()) width->fail_expected("a number or an expression");
  corridor.width = read_number(*width, draft, dimension, SignConstraint::positive);
  read_centreline(*along, draft, trajectory);
  if (const double radius = radius_of(trajectory); !(corridor.width.value() < radius))
    width->fail({.expected = fmt::format("a width less than the circle's radius ({:.6g} m)", radius),
                 .found = fmt::format("{:.6g} m", corridor.width.value())});
  trajectory.corridor = std::move(corridor);
}

}  // namespace balance::specification
