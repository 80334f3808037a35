#include "balance/base/nearest.hpp"
#include "balance/spec/draft.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace balance::read {

namespace {

std::vector<std::string> body_names(const Draft& draft) {
  std::vector<std::string> names;
  for (const auto& body : draft.mechanism().bodies) names.push_back(body.name);
  return names;
}

BodyId find_body(const Cursor& at, const std::string& name, const Draft& draft) {
  if (const int found = draft.bodies.find(draft.mechanism().bodies, name); found >= 0) return found;
  const auto names = body_names(draft);
  at.fail_unless_doubtful("bodies." + name, {.expected = fmt::format("a body ({})", one_of(names)),
                                             .found = in_quotes(name),
                                             .hint = nearest_is(name, names)});
}

/// Where the longest body's name ends that a reference begins with; without one all but the last of its names.
std::size_t end_of_body(const std::string& text, const Draft& draft) {
  for (auto dot = text.rfind('.'); dot != std::string::npos && dot > 0; dot = text.rfind('.', dot - 1))
    if (draft.bodies.find(draft.mechanism().bodies, text.substr(0, dot)) >= 0) return dot;
  return text.rfind('.');
}

/// Every body has a point `origin`, unless it defines one of that name elsewhere.
Vector3E find_point(const Cursor& at, const std::string& name, const BodyOf<Expression>& body) {
  std::vector<std::string> names;
  for (const auto& point : body.points)
    if (point.name == name) return point.position;
  if (name == "origin") return Vector3E::Zero();
  for (const auto& point : body.points) names.push_back(point.name);
  names.emplace_back("origin");
  const std::string points = body.name == "ground" ? "ground.points" : "bodies." + body.name + ".points";
  const Problems& problems = at.problems();
  if (problems.doubtful(points + "." + name) || (body.points.empty() && problems.lost(points))) throw Consequence();
  at.fail({.expected = fmt::format("a point of {} ({})", body.name, one_of(names)),
           .found = in_quotes(name),
           .hint = nearest_is(name, names)});
}

}  // namespace

BodyId read_body(const Cursor& at, const Draft& draft) { return find_body(at, at.word("a body's name"), draft); }

PointReference read_reference(const Cursor& at, const Draft& draft) {
  const std::string what = "a point, body.point";
  const std::string& text = at.word(what);
  const auto dot = end_of_body(text, draft);
  if (dot == std::string::npos) {
    const auto names = body_names(draft);
    const bool body_alone = std::find(names.begin(), names.end(), text) != names.end();
    at.fail({.expected = what,
             .found = at.found(),
             .hint = body_alone ? "the body's own frame is " + in_quotes(text + ".origin") : ""});
  }
  PointReference reference;
  reference.body = find_body(at, text.substr(0, dot), draft);
  reference.name = text.substr(dot + 1);
  reference.position =
      find_point(at, reference.name, draft.mechanism().bodies[static_cast<std::size_t>(reference.body)]);
  return reference;
}

Vector3E read_place(const Cursor& at, Draft& draft, std::optional<BodyId> body) {
  if (at.is_list()) return read_vector(at, draft, dimension::length);
  if (!body) throw Consequence();
  const auto& owner = draft.mechanism().bodies[static_cast<std::size_t>(*body)];
  std::string name = at.word("a point of " + owner.name + " or its coordinates");
  if (name.rfind(owner.name + ".", 0) == 0) name.erase(0, owner.name.size() + 1);
  return find_point(at, name, owner);
}

CoordinateId find_coordinate(const Cursor& at, const std::string& name, const Draft& draft) {
  const auto& mechanism = draft.mechanism();
  const auto& coordinates = mechanism.coordinates;
  if (const int found = draft.coordinates.find(coordinates, name); found >= 0) return found;
  std::vector<std::string> names;
  for (const Coordinate& coordinate : coordinates) names.push_back(coordinate.name);
  for (const auto& joint : mechanism.joints) {
    const bool meant = name == joint.name || name.starts_with(joint.name + ".");
    if (meant && at.problems().doubtful("joints." + joint.name + ".type")) throw Consequence();
    if (joint.name != name) continue;
    if (freedom(joint.type) == 0)
      at.fail({.expected = "a joint coordinate",
               .found = fmt::format("{}, a fixed joint, which has none", in_quotes(name))});
    std::vector<std::string> own;
    for (const Coordinate& c : mechanism.coordinates)
      if (mechanism.joints[static_cast<std::size_t>(c.joint)].name == name) own.push_back(c.name);
    at.fail({.expected = fmt::format("one coordinate of joint {} ({})", name, one_of(own)), .found = in_quotes(name)});
  }
  at.fail_unless_doubtful("joints." + name, {.expected = fmt::format("a joint coordinate ({})",
                                                                     names.empty() ? "there are none" : one_of(names)),
                                             .found = in_quotes(name),
                                             .hint = nearest_is(name, names)});
}

CoordinateId read_coordinate(const Cursor& at, const Draft& draft) {
  return find_coordinate(at, at.word("a joint coordinate's name"), draft);
}

std::vector<CoordinateValueOf<Expression>> read_coordinate_values(const Cursor& at, Draft& draft) {
  std::vector<CoordinateValueOf<Expression>> values;
  for (const Member& member : members(at, "a mapping of joint coordinates to values")) {
    at.problems().guard([&] {
      const CoordinateId coordinate = find_coordinate(member.key, member.name, draft);
      const CoordinateKind kind = draft.mechanism().coordinates[static_cast<std::size_t>(coordinate)].kind;
      values.push_back({coordinate, read_number(member.value, draft, dimension_of(kind))});
    });
  }
  return values;
}

}  // namespace balance::read
