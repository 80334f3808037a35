#include "balance/interface/specification/read_speeds.hpp"

#include "balance/foundation/base/spelling.hpp"
#include "balance/foundation/expression/expression_parser.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
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
    if (name == body.name + ".com") return PointReference{static_cast<int>(b), "com", body.com};
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
  for (const VelocityComponent& component : velocity_components)
    if (component.kind == velocity && (draft.planar() ? component.planar : component.spatial))
      names.push_back(std::string("com.") + component.name);
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

/// A component of the velocity of the centre of mass of everything that moves.
model::GeneralisedSpeedTermOf<Expression> com_term(const SpecCursor& at, const VelocityComponent& component,
                                                   SpeedUse use, const StudyBuilder& draft) {
  if (use == SpeedUse::constraint)
    at.fail({.expected = "a velocity of a body: no force on bodies keeps the speed of the common centre of mass",
             .found = quote_for_message(std::string("com.") + component.name)});
  if (component.kind != velocity)
    at.fail({.expected = draft.planar()
                             ? "com.x or com.y: the centre of mass of all has neither axes nor an angle"
                             : "com.x, com.y or com.z: the centre of mass of all has neither axes nor angles",
             .found = quote_for_message(std::string("com.") + component.name)});
  model::GeneralisedSpeedTermOf<Expression> term;
  term.kind = model::GeneralisedSpeedTermOf<Expression>::Kind::com_velocity;
  term.index = component.index;
  return term;
}

/// The name of a coordinate takes precedence over that of a place, and that over `com`.
model::GeneralisedSpeedTermOf<Expression> term_of(const SpecCursor& at, const std::string& name, SpeedUse use,
                                                  const StudyBuilder& draft) {
  const auto& coordinates = draft.mechanism().coordinates;
  for (std::size_t c = 0; c < coordinates.size(); ++c)
    if (coordinates[c].name == name) return {.index = static_cast<int>(c)};
  const std::size_t dot = name.rfind('.');
  const VelocityComponent* component =
      dot == std::string::npos ? nullptr : find_component(name.substr(dot + 1), draft.planar());
  const std::optional<PointReference> point =
      component == nullptr ? std::nullopt : find_point_reference(name.substr(0, dot), draft);
  if (!point && component != nullptr && name.substr(0, dot) == "com") return com_term(at, *component, use, draft);
  const bool lacks_tool = name.starts_with("tool.") && !draft.mechanism().tool;
  if (!point)
    at.fail(
        {.expected = fmt::format("a joint coordinate, or a component ({}) of the motion of the tool or of a body's "
                                 "point, as in 'tool.x' or 'body.point.x'{}",
                                 component_list(draft.planar()),
                                 use == SpeedUse::constraint ? "" : ", or com.x and the like of the centre of mass"),
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
  if (term.kind != Kind::coordinate)
    return term.kind != Kind::angular_velocity && term.kind != Kind::angular_velocity_body;
  return draft.mechanism().coordinates[static_cast<std::size_t>(term.index)].kind == CoordinateKind::length;
}

// Factors that depend on the pose, and values that depend on time.

using FunctionE = model::VariableFunctionOf<Expression>;

/// A variable of an expression: its name, and its unit in the spec as an SI number.
struct FunctionVariable {
  std::string name;
  double unit = 1;
};

/// Records an expression of variables and parameters.
/// @param unit of its value, as an SI number
/// @param value on return, its value with all variables zero
FunctionE record_function(const SpecCursor& at, const std::vector<FunctionVariable>& variables, double unit,
                          StudyBuilder& draft, double& value) {
  const auto graph = std::make_shared<expression::ExpressionGraph>();
  std::vector<std::string> names;
  std::map<std::string, Expression> inputs;
  for (const FunctionVariable& variable : variables) {
    names.push_back(variable.name);
    inputs.emplace(variable.name, Expression::input(*graph, 0) / variable.unit);
  }
  FunctionE function;
  const Expression result =
      unit * draft.parameters.evaluate(at, names, [&](const std::string& name, const Expression* parameter) {
        if (parameter == nullptr) return inputs.at(name);
        const auto [entry, is_new] = inputs.insert_or_assign(name, Expression::input(*graph, parameter->value()));
        function.parameters.push_back(*parameter);
        return entry->second;
      });
  value = result.value();
  function.node = result.is_constant() ? graph->add({.constant = value}) : result.node();
  function.graph = graph;
  return function;
}

/// Names of values in a scalar's expression.
std::vector<std::string> names_in(const SpecCursor& at) {
  return at.is_scalar() ? expression::find_expression_names(at.node().text).values : std::vector<std::string>();
}

bool is_parameter(const std::string& name, const StudyBuilder& draft) {
  const std::vector<std::string>& names = draft.parameters.names();
  return std::find(names.begin(), names.end(), name) != names.end();
}

/// The joint coordinates that a factor contains.
std::vector<CoordinateId> find_pose_variables(const SpecCursor& at, const StudyBuilder& draft) {
  std::vector<CoordinateId> variables;
  const auto& coordinates = draft.mechanism().coordinates;
  for (const std::string& name : names_in(at))
    for (std::size_t c = 0; c < coordinates.size(); ++c)
      if (coordinates[c].name == name && !is_parameter(name, draft)) variables.emplace_back(static_cast<int>(c));
  return variables;
}

/// An expression of joint coordinates, in radians and in the spec's unit of length.
void read_pose_factor(const SpecCursor& at, const std::vector<CoordinateId>& variables, Dimension dimension,
                      StudyBuilder& draft, model::GeneralisedSpeedTermOf<Expression>& term) {
  std::vector<FunctionVariable> names;
  for (const CoordinateId c : variables) {
    const Coordinate& coordinate = draft.mechanism().coordinates[static_cast<std::size_t>(c)];
    names.push_back(
        {coordinate.name, coordinate.kind == CoordinateKind::length ? draft.units.factor(dimension::length) : 1});
  }
  double ignored = 0;
  term.pose_factor = record_function(at, names, draft.units.factor(dimension), draft, ignored);
  term.pose_variables = variables;
}

/// What a constrained sum equals: a number, or an expression of the time t [s].
void read_value(const SpecCursor& at, Dimension dimension, StudyBuilder& draft,
                model::GeneralisedSpeedOf<Expression>& speed) {
  if (!at.is_scalar()) at.fail_expected("a speed, or an expression of the time t");
  if (is_parameter(time_name, draft))
    for (const std::string& name : names_in(at))
      if (name == time_name)
        at.fail({.expected = "an expression in which t is the time",
                 .found = "a parameter t",
                 .hint = "give the parameter another name"});
  double start = 0;
  speed.value = record_function(at, {{time_name, draft.units.factor(dimension::time)}}, draft.units.factor(dimension),
                                draft, start);
  if (!std::isfinite(start)) at.fail({.expected = "a speed that is finite at t = 0", .found = at.describe_found()});
}

void read_factor(const SpecCursor& value, Dimension dimension, SpeedUse use, StudyBuilder& draft,
                 model::GeneralisedSpeedTermOf<Expression>& term) {
  if (!value.is_scalar() && !value.is_map()) value.fail_expected("a number");
  const std::vector<CoordinateId> variables = find_pose_variables(value, draft);
  if (!variables.empty() && use == SpeedUse::constraint)
    value.fail({.expected = "a factor that does not depend on the pose (components u, v, w turn with the body)",
                .found = value.describe_found()});
  if (!variables.empty()) return read_pose_factor(value, variables, dimension, draft, term);
  term.factor = read_number(value, draft, dimension);
  if (!std::isfinite(term.factor.value())) value.fail_expected("a finite number");
  if (value.is_scalar() && term.factor.value() == 0)
    value.fail({.expected = "a factor other than 0 (leave out terms that do not count)", .found = "0"});
}

}  // namespace

model::GeneralisedSpeedOf<Expression> read_speed(const Member& member, SpeedUse use, StudyBuilder& draft) {
  model::GeneralisedSpeedOf<Expression> speed{member.name, {}};
  if (member.value.is_scalar()) {
    speed.terms.push_back(
        term_of(member.value, member.value.read_word("a joint coordinate or a component of a motion"), use, draft));
    return speed;
  }
  std::vector<Member> members =
      list_members(member.value, "a joint coordinate, a component of a motion, or a mapping of these to factors");
  std::optional<SpecCursor> value;
  const auto& coordinates = draft.mechanism().coordinates;
  const bool has_value_coordinate = std::any_of(coordinates.begin(), coordinates.end(),
                                                [](const Coordinate& c) { return c.name == constraint_value_key; });
  std::erase_if(members, [&](const Member& one) {
    if (one.name != constraint_value_key || has_value_coordinate) return false;
    if (use != SpeedUse::constraint)
      one.key.fail({.expected = "no 'value': only a constraint has one", .found = quote_for_message(one.name)});
    value = one.value;
    return true;
  });
  for (const Member& one : members) speed.terms.push_back(term_of(one.key, one.name, use, draft));
  if (members.empty()) member.value.fail({.expected = "at least one term", .found = member.value.describe_found()});
  const bool velocity =
      std::any_of(speed.terms.begin(), speed.terms.end(), [&](const auto& term) { return is_length(term, draft); });
  for (std::size_t k = 0; k < members.size(); ++k) {
    const bool angle = velocity && !is_length(speed.terms[k], draft);
    read_factor(members[k].value, angle ? dimension::length / dimension::angle : dimension::dimensionless, use, draft,
                speed.terms[k]);
  }
  if (value) read_value(*value, (velocity ? dimension::length : dimension::angle) / dimension::time, draft, speed);
  return speed;
}

model::GeneralisedSpeed to_numbers(const model::GeneralisedSpeedOf<Expression>& speed) {
  const auto number = [](const Expression& x) { return x.value(); };
  model::GeneralisedSpeed out{speed.name, {}, speed.value.convert<double>(number)};
  for (const auto& term : speed.terms)
    out.terms.push_back({static_cast<model::GeneralisedSpeedTerm::Kind>(term.kind), term.index, term.factor.value(),
                         term.body,
                         Vector3(term.position[0].value(), term.position[1].value(), term.position[2].value()),
                         term.pose_factor.convert<double>(number), term.pose_variables});
  return out;
}

std::vector<model::GeneralisedSpeed> read_speeds(const SpecCursor& section, StudyBuilder& draft) {
  std::vector<model::GeneralisedSpeed> speeds;
  for (const Member& member : list_named_members(section, "a mapping of speeds"))
    draft.problems.collect([&] { speeds.push_back(to_numbers(read_speed(member, SpeedUse::quasi_velocity, draft))); });
  return speeds;
}

void read_constraints(const SpecCursor& section, StudyBuilder& draft) {
  for (const Member& member : list_named_members(section, "a mapping of constraints: sums of speeds"))
    draft.problems.collect(
        [&] { draft.mechanism().constraints.push_back(read_speed(member, SpeedUse::constraint, draft)); });
}

}  // namespace balance::specification
