#include "balance/interface/specification/read_speeds.hpp"

#include "balance/foundation/base/spelling.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

namespace balance::specification {

namespace {

struct VelocityComponent {
  const char* name;
  model::GeneralisedSpeedTerm::Kind kind;
  int index;
  bool planar, spatial;
};

using enum model::GeneralisedSpeedTerm::Kind;
constexpr VelocityComponent velocity_components[]{
    {"x", velocity, 0, true, true},
    {"y", velocity, 1, true, true},
    {"z", velocity, 2, false, true},
    {"u", velocity_body, 0, true, true},
    {"v", velocity_body, 1, true, true},
    {"w", velocity_body, 2, false, true},
    {"angle", angular_velocity, 2, true, false},
    {"rx", angular_velocity, 0, false, true},
    {"ry", angular_velocity, 1, false, true},
    {"rz", angular_velocity, 2, false, true},
    {"p", angular_velocity_body, 0, false, true},
    {"q", angular_velocity_body, 1, false, true},
    {"r", angular_velocity_body, 2, false, true},
};

bool is_turning(model::GeneralisedSpeedTerm::Kind kind) {
  return kind == angular_velocity || kind == angular_velocity_body;
}

const VelocityComponent* find_component(const std::string& name, bool planar) {
  for (const VelocityComponent& component : velocity_components)
    if ((planar ? component.planar : component.spatial) && component.name == name) return &component;
  return nullptr;
}

/// Resolves `tool`, or a body's name with or without one of its points; std::nullopt if there is no such place.
std::optional<PointReference> find_point_reference(const std::string& name, const StudyBuilder& draft) {
  const auto& mechanism = draft.mechanism();
  if (name == "tool" && mechanism.tool)
    return PointReference{mechanism.tool->body, mechanism.tool->point, mechanism.tool->position};
  for (std::size_t b = 0; b < mechanism.bodies.size(); ++b) {
    const auto& body = mechanism.bodies[b];
    if (body.name == name) return PointReference{static_cast<int>(b), "", Vector3E::Zero()};
    if (!name.starts_with(body.name + ".")) continue;
    for (const auto& point : body.points)
      if (name == body.name + "." + point.name) return PointReference{static_cast<int>(b), point.name, point.position};
    if (name == body.name + ".origin") return PointReference{static_cast<int>(b), "origin", Vector3E::Zero()};
  }
  return std::nullopt;
}

/// Possible names, for a hint.
std::vector<std::string> all_names(const StudyBuilder& draft) {
  std::vector<std::string> names;
  for (const Coordinate& coordinate : draft.mechanism().coordinates) names.push_back(coordinate.name);
  const auto add = [&](const std::string& place) {
    for (const VelocityComponent& component : velocity_components)
      if (draft.planar() ? component.planar : component.spatial) names.push_back(place + "." + component.name);
  };
  if (draft.mechanism().tool) add("tool");
  for (const auto& body : draft.mechanism().bodies)
    for (const auto& point : body.points) add(body.name + "." + point.name);
  return names;
}

std::string component_list(bool planar) {
  std::vector<std::string> names;
  for (const VelocityComponent& component : velocity_components)
    if (planar ? component.planar : component.spatial) names.emplace_back(component.name);
  return join_alternatives(names);
}

/// The name of a coordinate takes precedence over that of a place.
model::GeneralisedSpeedTermOf<Expression> term_of(const SpecCursor& at, const std::string& name,
                                                  const StudyBuilder& draft) {
  const auto& coordinates = draft.mechanism().coordinates;
  for (std::size_t c = 0; c < coordinates.size(); ++c)
    if (coordinates[c].name == name) return {.index = static_cast<int>(c)};
  const std::size_t dot = name.rfind('.');
  const VelocityComponent* component =
      dot == std::string::npos ? nullptr : find_component(name.substr(dot + 1), draft.planar());
  const std::optional<PointReference> point =
      component == nullptr ? std::nullopt : find_point_reference(name.substr(0, dot), draft);
  const bool lacks_tool = name.starts_with("tool.") && !draft.mechanism().tool;
  if (!point)
    at.fail({.expected = fmt::format("a joint coordinate, or a component ({}) of the motion of the tool or of a body's "
                                     "point, as in 'tool.x' or 'body.point.x'",
                                     component_list(draft.planar())),
             .found = quote_for_message(name),
             .hint = lacks_tool ? "speeds of the tool need a tool, which the spec lacks"
                                : format_nearest_name(name, all_names(draft))});
  if (point->name.empty() && !is_turning(component->kind))
    at.fail({.expected = fmt::format("a point of the body, as in '{}.origin.{}'", name.substr(0, dot), component->name),
             .found = quote_for_message(name)});
  model::GeneralisedSpeedTermOf<Expression> term;
  term.kind = static_cast<model::GeneralisedSpeedTermOf<Expression>::Kind>(component->kind);
  term.index = component->index;
  term.body = point->body;
  if (!is_turning(component->kind)) term.position = point->position;
  return term;
}

bool is_length(const model::GeneralisedSpeedTermOf<Expression>& term, const StudyBuilder& draft) {
  using Kind = model::GeneralisedSpeedTermOf<Expression>::Kind;
  if (term.kind != Kind::coordinate) return term.kind == Kind::velocity || term.kind == Kind::velocity_body;
  return draft.mechanism().coordinates[static_cast<std::size_t>(term.index)].kind == CoordinateKind::length;
}

}  // namespace

model::GeneralisedSpeedOf<Expression> read_speed(const Member& member, StudyBuilder& draft) {
  model::GeneralisedSpeedOf<Expression> speed{member.name, {}};
  if (member.value.is_scalar()) {
    speed.terms.push_back(
        term_of(member.value, member.value.read_word("a joint coordinate or a component of a motion"), draft));
    return speed;
  }
  const std::vector<Member> members =
      list_members(member.value, "a joint coordinate, a component of a motion, or a mapping of these to factors");
  for (const Member& one : members) speed.terms.push_back(term_of(one.key, one.name, draft));
  if (members.empty()) member.value.fail({.expected = "at least one term", .found = member.value.describe_found()});
  const bool velocity =
      std::any_of(speed.terms.begin(), speed.terms.end(), [&](const auto& term) { return is_length(term, draft); });
  for (std::size_t k = 0; k < members.size(); ++k) {
    const SpecCursor& value = members[k].value;
    if (!value.is_scalar() && !value.is_map()) value.fail_expected("a number");
    const bool angle = velocity && !is_length(speed.terms[k], draft);
    speed.terms[k].factor =
        read_number(value, draft, angle ? dimension::length / dimension::angle : dimension::dimensionless);
    if (!std::isfinite(speed.terms[k].factor.value())) value.fail_expected("a finite number");
    if (value.is_scalar() && speed.terms[k].factor.value() == 0)
      value.fail({.expected = "a factor other than 0 (leave out terms that do not count)", .found = "0"});
  }
  return speed;
}

model::GeneralisedSpeed value_of(const model::GeneralisedSpeedOf<Expression>& speed) {
  model::GeneralisedSpeed out{speed.name, {}};
  for (const auto& term : speed.terms)
    out.terms.push_back({static_cast<model::GeneralisedSpeedTerm::Kind>(term.kind), term.index, term.factor.value(),
                         term.body,
                         Vector3(term.position[0].value(), term.position[1].value(), term.position[2].value())});
  return out;
}

std::vector<model::GeneralisedSpeed> read_speeds(const SpecCursor& section, StudyBuilder& draft) {
  std::vector<model::GeneralisedSpeed> speeds;
  for (const Member& member : list_named_members(section, "a mapping of speeds"))
    draft.problems.collect([&] { speeds.push_back(value_of(read_speed(member, draft))); });
  return speeds;
}

void read_constraints(const SpecCursor& section, StudyBuilder& draft) {
  for (const Member& member : list_named_members(section, "a mapping of constraints: sums of speeds that are zero"))
    draft.problems.collect([&] { draft.mechanism().constraints.push_back(read_speed(member, draft)); });
}

}  // namespace balance::specification
