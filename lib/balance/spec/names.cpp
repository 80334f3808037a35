#include "balance/base/nearest.hpp"
#include "balance/spec/draft.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace balance::specification {

namespace {

std::vector<std::string> body_names(const StudyBuilder& draft) {
  std::vector<std::string> names;
  for (const auto& body : draft.mechanism().bodies) names.push_back(body.name);
  return names;
}

BodyId find_body(const SpecCursor& at, const std::string& name, const StudyBuilder& draft) {
  if (const int found = draft.bodies.find(draft.mechanism().bodies, name); found >= 0) return found;
  const auto names = body_names(draft);
  at.fail_unless_uncertain("bodies." + name, {.expected = fmt::format("a body ({})", join_alternatives(names)),
                                              .found = quote_for_message(name),
                                              .hint = format_nearest_name(name, names)});
}

/// Where the longest body's name ends that a reference begins with; without one all but the last of its names.
std::size_t body_name_length(const std::string& text, const StudyBuilder& draft) {
  for (auto dot = text.rfind('.'); dot != std::string::npos && dot > 0; dot = text.rfind('.', dot - 1))
    if (draft.bodies.find(draft.mechanism().bodies, text.substr(0, dot)) >= 0) return dot;
  return text.rfind('.');
}

/// Every body has a point `origin`, unless it defines one of that name elsewhere.
Vector3E find_point(const SpecCursor& at, const std::string& name, const BodyOf<Expression>& body) {
  std::vector<std::string> names;
  for (const auto& point : body.points)
    if (point.name == name) return point.position;
  if (name == "origin") return Vector3E::Zero();
  for (const auto& point : body.points) names.push_back(point.name);
  names.emplace_back("origin");
  const std::string points = body.name == "ground" ? "ground.points" : "bodies." + body.name + ".points";
  const SpecErrorCollector& problems = at.problems();
  if (problems.is_uncertain(points + "." + name) || (body.points.empty() && problems.is_section_invalid(points)))
    throw CascadingError();
  at.fail({.expected = fmt::format("a point of {} ({})", body.name, join_alternatives(names)),
           .found = quote_for_message(name),
           .hint = format_nearest_name(name, names)});
}

}  // namespace

BodyId read_body(const SpecCursor& at, const StudyBuilder& draft) {
  return find_body(at, at.read_word("a body's name"), draft);
}

PointReference read_reference(const SpecCursor& at, const StudyBuilder& draft) {
  const std::string what = "a point, body.point";
  const std::string& text = at.read_word(what);
  const auto dot = body_name_length(text, draft);
  if (dot == std::string::npos) {
    const auto names = body_names(draft);
    const bool body_alone = std::find(names.begin(), names.end(), text) != names.end();
    at.fail({.expected = what,
             .found = at.describe_found(),
             .hint = body_alone ? "the body's own frame is " + quote_for_message(text + ".origin") : ""});
  }
  PointReference reference;
  reference.body = find_body(at, text.substr(0, dot), draft);
  reference.name = text.substr(dot + 1);
  reference.position =
      find_point(at, reference.name, draft.mechanism().bodies[static_cast<std::size_t>(reference.body)]);
  return reference;
}

Vector3E read_position(const SpecCursor& at, StudyBuilder& draft, std::optional<BodyId> body) {
  if (at.is_list()) return read_vector(at, draft, dimension::length);
  if (!body) throw CascadingError();
  const auto& owner = draft.mechanism().bodies[static_cast<std::size_t>(*body)];
  std::string name = at.read_word("a point of " + owner.name + " or its coordinates");
  if (name.rfind(owner.name + ".", 0) == 0) name.erase(0, owner.name.size() + 1);
  return find_point(at, name, owner);
}

CoordinateId find_coordinate(const SpecCursor& at, const std::string& name, const StudyBuilder& draft) {
  const auto& mechanism = draft.mechanism();
  const auto& coordinates = mechanism.coordinates;
  if (const int found = draft.coordinates.find(coordinates, name); found >= 0) return found;
  std::vector<std::string> names;
  for (const Coordinate& coordinate : coordinates) names.push_back(coordinate.name);
  for (const auto& joint : mechanism.joints) {
    const bool meant = name == joint.name || name.starts_with(joint.name + ".");
    if (meant && at.problems().is_uncertain("joints." + joint.name + ".type")) throw CascadingError();
    if (joint.name != name) continue;
    if (joint_degrees_of_freedom(joint.type) == 0)
      at.fail({.expected = "a joint coordinate",
               .found = fmt::format("{}, a fixed joint, which has none", quote_for_message(name))});
    std::vector<std::string> own;
    for (const Coordinate& c : mechanism.coordinates)
      if (mechanism.joints[static_cast<std::size_t>(c.joint)].name == name) own.push_back(c.name);
    at.fail({.expected = fmt::format("one coordinate of joint {} ({})", name, join_alternatives(own)),
             .found = quote_for_message(name)});
  }
  at.fail_unless_uncertain(
      "joints." + name,
      {.expected = fmt::format("a joint coordinate ({})", names.empty() ? "there are none" : join_alternatives(names)),
       .found = quote_for_message(name),
       .hint = format_nearest_name(name, names)});
}

CoordinateId read_coordinate(const SpecCursor& at, const StudyBuilder& draft) {
  return find_coordinate(at, at.read_word("a joint coordinate's name"), draft);
}

std::vector<CoordinateValueOf<Expression>> read_coordinate_values(const SpecCursor& at, StudyBuilder& draft) {
  std::vector<CoordinateValueOf<Expression>> values;
  for (const Member& member : list_members(at, "a mapping of joint coordinates to values")) {
    at.problems().collect([&] {
      const CoordinateId coordinate = find_coordinate(member.key, member.name, draft);
      const CoordinateKind kind = draft.mechanism().coordinates[static_cast<std::size_t>(coordinate)].kind;
      values.push_back({coordinate, read_number(member.value, draft, dimension_of(kind))});
    });
  }
  return values;
}

}  // namespace balance::specification
