#include "balance/spec/path.hpp"

#include "balance/spec/directions.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <limits>

namespace balance::read {

namespace {

constexpr int most_knots = 100;
constexpr int most_starts = 100;

/// Of the space that the path lies in: joint coordinates are its axes where joints are driven.
Dimension width_dimension(const Cursor& at, const TrajectoryOf<Expression>& trajectory, const Draft& draft) {
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
void read_middle(const Cursor& at, Draft& draft, TrajectoryOf<Expression>& trajectory) {
  read_path(at, draft, trajectory);
  if (trajectory.corridor || std::holds_alternative<WaypointPathOf<Expression>>(trajectory.path) ||
      std::holds_alternative<TablePathOf<Expression>>(trajectory.path))
    at.fail({.expected = "line, {circle: …} or {arc: …}: a corridor needs a path without corners and bends of its own",
             .found = "another path"});
}

/// What a law leaves open must be left to the search: nothing beside it depends on where the mechanism is when.
void check_company(const Cursor& at, const TrajectoryOf<Expression>& trajectory) {
  const auto& components = trajectory.components;
  const auto turns = [](Component c) { return c >= Component::rx; };
  if (!components.empty() && std::count_if(components.begin(), components.end(), std::not_fn(turns)) < 2)
    at.fail(
        {.expected = "at least two coordinates of a point among the components: one leaves no room beside its path"});
  if (trajectory.law.kind == LawKind::steady_momentum)
    at.fail({.expected = "no corridor with the law 'steady-momentum', which leaves nothing to be made least"});
  if (trajectory.start_speed.value() != 0 || trajectory.end_speed.value() != 0)
    at.fail({.expected = "no corridor beside 'speeds': the motion starts and ends at rest"});
  for (const auto& course : trajectory.courses) {
    const auto* spline = std::get_if<AddedSplineOf<Expression>>(&course.kind);
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

Cursor middle_of(const Cursor& path) {
  const auto member = [](const Cursor& map, const std::string& name) -> std::optional<Cursor> {
    if (!map.is_map()) return std::nullopt;
    const Node& node = map.node();
    for (std::size_t i = 0; i < node.keys.size() && i < node.items.size(); ++i)
      if (node.keys[i].text == name) return Cursor(node.items[i], map.path() + "." + name, map.problems());
    return std::nullopt;
  };
  const auto corridor = member(path, "corridor");
  const auto along = corridor ? member(*corridor, "along") : std::nullopt;
  return along ? *along : path;
}

void read_corridor(const Cursor& at, Draft& draft, TrajectoryOf<Expression>& trajectory) {
  std::optional<Cursor> along, width;
  CorridorOf<Expression> corridor;
  const bool read = read_fields(
      at, "a corridor {along, width}",
      {{"along", Need::required, [&](const Cursor& c) { along = c; }},
       {"width", Need::required, [&](const Cursor& c) { width = c; }},
       {"knots", Need::optional,
        [&](const Cursor& c) { corridor.knots = static_cast<int>(read_whole(c, draft, 1, most_knots)); }},
       {"starts", Need::optional,
        [&](const Cursor& c) { corridor.starts = static_cast<int>(read_whole(c, draft, 1, most_starts)); }}});
  if (!read) return;
  check_company(at, trajectory);
  const Dimension dimension = width_dimension(at, trajectory, draft);
  if (!width->is_scalar()) width->expected("a number or an expression");
  corridor.width = read_number(*width, draft, dimension, Sign::positive);
  read_middle(*along, draft, trajectory);
  if (const double radius = radius_of(trajectory); !(corridor.width.value() < radius))
    width->fail({.expected = fmt::format("a width less than the circle's radius ({:.6g} m)", radius),
                 .found = fmt::format("{:.6g} m", corridor.width.value())});
  trajectory.corridor = std::move(corridor);
}

}  // namespace balance::read
