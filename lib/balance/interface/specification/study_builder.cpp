#include "balance/interface/specification/study_builder.hpp"

#include "balance/foundation/base/spelling.hpp"
#include "balance/interface/specification/free_number.hpp"
#include "balance/interface/specification/read_load_cases.hpp"
#include "balance/interface/specification/read_tolerance_section.hpp"
#include "balance/mechanics/trajectory/trajectory.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <span>

namespace balance::specification {

Vector3E normalized(const Vector3E& v) { return v / sqrt(v.squaredNorm()); }

Matrix3E rotation_about(int axis, const Expression& angle) {
  const int next = (axis + 1) % 3, last = (axis + 2) % 3;
  const Expression c = cos(angle), s = sin(angle);
  Matrix3E rotation = Matrix3E::Identity();
  rotation(next, next) = rotation(last, last) = c;
  rotation(last, next) = s;
  rotation(next, last) = -s;
  return rotation;
}

Matrix3E rotation_from_rpy(const Vector3E& rpy) {
  return rotation_about(2, rpy[2]) * rotation_about(1, rpy[1]) * rotation_about(0, rpy[0]);
}

Matrix3E rotation_from_vector(const Vector3E& v) {
  const Expression angle = sqrt(v.squaredNorm());
  Matrix3E k;
  k << 0, -v[2], v[1], v[2], 0, -v[0], -v[1], v[0], 0;
  k /= angle;
  const Matrix3E identity = Matrix3E::Identity();
  const Matrix3E rotation = identity + sin(angle) * k + (1.0 - cos(angle)) * (k * k);
  return choose(equal(angle, 0), identity, rotation);
}

Matrix3E rotation_from_quaternion(const std::vector<Expression>& q) {
  Expression squared_norm = 0;
  for (const Expression& component : q) squared_norm += component * component;
  const Expression scale = 1.0 / sqrt(squared_norm);
  const Expression w = q[0] * scale, x = q[1] * scale, y = q[2] * scale, z = q[3] * scale;
  Matrix3E rotation;
  rotation << 1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y),  //
      2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x),          //
      2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y);
  return rotation;
}

Matrix3 values_of(const Matrix3E& matrix) {
  return matrix.unaryExpr([](const Expression& x) { return x.value(); });
}

Vector3 values_of(const Vector3E& vector) {
  return vector.unaryExpr([](const Expression& x) { return x.value(); });
}

// Coordinates that discs and couplings follow: a joint coordinate, or several with a ratio each.
model::CoordinateCombinationOf<Expression> read_followed(const SpecCursor& at, StudyBuilder& draft,
                                                         const Dimension& follower) {
  if (!at.is_map()) return read_coordinate(at, draft);
  std::vector<model::CoordinateTermOf<Expression>> terms;
  std::set<int> followed;
  bool is_valid = true;
  for (const Member& member : list_members(at, "a joint coordinate, or a mapping of joint coordinates to ratios")) {
    const auto read = [&] {
      const CoordinateId coordinate = find_coordinate(member.key, member.name, draft);
      const CoordinateKind kind = draft.mechanism().coordinates[static_cast<std::size_t>(coordinate)].kind;
      const Expression ratio = read_number(member.value, draft, follower / dimension_of(kind));
      if (is_fixed_zero(member.value, ratio, draft))
        member.value.fail({.expected = "a ratio other than 0 (leave out what is not followed)", .found = "0"});
      if (followed.insert(coordinate).second) terms.push_back({coordinate, ratio});
    };
    is_valid = draft.problems.collect(read) && is_valid;
  }
  if (!is_valid) throw CascadingError();
  if (terms.empty()) at.fail({.expected = "at least one joint coordinate", .found = at.describe_found()});
  return model::CoordinateCombinationOf<Expression>(std::move(terms));
}

bool has_several_leaders(const SpecCursor& map) {
  if (!map.is_map()) return false;
  const YamlNode& node = map.node();
  for (std::size_t k = 0; k < node.keys.size(); ++k)
    if (node.keys[k].text == "follows") return node.items[k].kind == YamlNode::Kind::map;
  return false;
}

namespace {

std::vector<std::string> body_names(const StudyBuilder& draft) {
  std::vector<std::string> names;
  for (const auto& body : draft.mechanism().bodies) names.push_back(body.name);
  return names;
}

BodyId find_body(const SpecCursor& at, const std::string& name, const StudyBuilder& draft) {
  if (const int id = draft.bodies.find(draft.mechanism().bodies, name); id >= 0) return id;
  const auto names = body_names(draft);
  at.fail_unless_uncertain("bodies." + name, {.expected = fmt::format("a body ({})", join_alternatives(names)),
                                              .found = quote_for_message(name),
                                              .hint = format_nearest_name(name, names)});
}

/// End of the longest body name that the reference begins with; if there is none, the end of
/// all its names but the last.
std::size_t body_name_length(const std::string& text, const StudyBuilder& draft) {
  for (auto dot = text.rfind('.'); dot != std::string::npos && dot > 0; dot = text.rfind('.', dot - 1))
    if (draft.bodies.find(draft.mechanism().bodies, text.substr(0, dot)) >= 0) return dot;
  return text.rfind('.');
}

/// Every body has a point `origin`, unless it defines one of that name elsewhere.
Vector3E find_point(const SpecCursor& at, const std::string& name, const model::BodyOf<Expression>& body) {
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
    const bool is_body_name = std::find(names.begin(), names.end(), text) != names.end();
    at.fail({.expected = what,
             .found = at.describe_found(),
             .hint = is_body_name ? "the body's own frame is " + quote_for_message(text + ".origin") : ""});
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
  if (const int id = draft.coordinates.find(coordinates, name); id >= 0) return id;
  std::vector<std::string> names;
  for (const Coordinate& coordinate : coordinates) names.push_back(coordinate.name);
  for (const auto& joint : mechanism.joints) {
    const bool names_joint = name == joint.name || name.starts_with(joint.name + ".");
    if (names_joint && at.problems().is_uncertain("joints." + joint.name + ".type")) throw CascadingError();
    if (joint.name != name) continue;
    if (joint_degrees_of_freedom(joint.type) == 0)
      at.fail({.expected = "a joint coordinate",
               .found = fmt::format("{}, a fixed joint, which has none", quote_for_message(name))});
    std::vector<std::string> joint_coordinates;
    for (const Coordinate& c : mechanism.coordinates)
      if (mechanism.joints[static_cast<std::size_t>(c.joint)].name == name) joint_coordinates.push_back(c.name);
    at.fail({.expected = fmt::format("one coordinate of joint {} ({})", name, join_alternatives(joint_coordinates)),
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

void list_joint_coordinates(StudyBuilder& draft) {
  std::vector<Joint> types;
  for (const auto& joint : draft.mechanism().joints) types.push_back({.name = joint.name, .type = joint.type});
  draft.mechanism().coordinates = list_coordinates(draft.mechanism().space, types);
}

std::vector<model::CoordinateValueOf<Expression>> read_coordinate_values(const SpecCursor& at, StudyBuilder& draft) {
  std::vector<model::CoordinateValueOf<Expression>> values;
  for (const Member& member : list_members(at, "a mapping of joint coordinates to values")) {
    at.problems().collect([&] {
      const CoordinateId coordinate = find_coordinate(member.key, member.name, draft);
      const CoordinateKind kind = draft.mechanism().coordinates[static_cast<std::size_t>(coordinate)].kind;
      values.push_back({coordinate, read_number(member.value, draft, dimension_of(kind))});
    });
  }
  return values;
}

namespace {

/// A number and, if it comes from an expression, that expression.
std::string found_number(const SpecCursor& at, double value) {
  const bool plain = !at.is_scalar() || expression::find_expression_names(at.node().text).values.empty();
  return plain ? fmt::format("{}", value)
               : fmt::format("{}, the value of {}", value, quote_for_message(at.node().text));
}

void check_sign(const SpecCursor& at, double value, SignConstraint sign) {
  if ((sign == SignConstraint::positive && !(value > 0)) || (sign == SignConstraint::positive_or_zero && !(value >= 0)))
    at.fail({.kind = "must be positive", .expected = "a number > 0", .found = found_number(at, value)});
  if (sign == SignConstraint::not_negative && value < 0)
    at.fail({.kind = "must not be negative", .expected = "a number ≥ 0", .found = found_number(at, value)});
}

double require_finite(const SpecCursor& at, double value) {
  if (!std::isfinite(value)) at.fail({.expected = "a number that is finite in SI units", .found = "one that is not"});
  return value;
}

std::string vector_form(std::size_t count) { return count == 2 ? "[x, y]" : "[x, y, z]"; }

Expression add_free_number(const SpecCursor& at, const std::string& path, const FreeValue& free, Dimension dimension,
                           StudyBuilder& draft) {
  const double unit = draft.units.factor(dimension);
  FreeNumber number{.key_path = path,
                    .lower = require_finite(at, free.lower * unit),
                    .upper = require_finite(at, free.upper * unit),
                    .start = require_finite(at, free.start * unit),
                    .start_source = free.start_source,
                    .unit = unit};
  draft.number_dimensions[path] = dimension;
  for (const double size : free.discrete_values) number.discrete_values.push_back(size * unit);
  const Expression input = draft.add_input(number.start);
  draft.free_numbers.push_back({&at.node(), number, input});
  draft.inputs.emplace(path, input);
  register_free_load_name(path, draft);
  return input;
}

}  // namespace

bool is_fixed_zero(const SpecCursor& at, const Expression& value, const StudyBuilder& draft) {
  if (value.value() != 0 || !at.is_scalar()) return false;
  return value.is_constant() || draft.parameters.free_numbers().empty();
}

namespace {

Expression read_exact(const SpecCursor& at, StudyBuilder& draft, Dimension dimension, SignConstraint sign) {
  const double unit = draft.units.factor(dimension);
  if (!at.is_map()) {
    const Expression value = draft.parameters.evaluate(at);
    check_sign(at, value.value(), sign);
    const Expression number = value * unit;
    require_finite(at, number.value());
    if (draft.requested_inputs.contains(at.path())) {
      const auto [entry, is_new] = draft.inputs.try_emplace(at.path());
      if (is_new) entry->second = draft.add_input(number.value());
      return entry->second;
    }
    return draft.load_names.empty() ? number : register_load_parameter(at, draft, number, dimension, sign);
  }
  if (const auto existing = draft.inputs.find(at.path()); existing != draft.inputs.end()) return existing->second;
  FreeValue free = draft.parameters.evaluate_free(at);
  if (is_added_element_path(at.path())) free.default_start_to_zero();
  // a bound of zero is allowed: the designer may want to know whether the mass can vanish
  check_sign(at, free.lower, sign == SignConstraint::none ? SignConstraint::none : SignConstraint::not_negative);
  check_sign(at, free.start, sign);
  return add_free_number(at, at.path(), free, dimension, draft);
}

}  // namespace

Expression read_number(const SpecCursor& at, StudyBuilder& draft, Dimension dimension, SignConstraint sign) {
  const Expression number = read_exact(at, draft, dimension, sign);
  return draft.tolerance_names.empty() ? number : register_toleranced_parameter(at, draft, number, dimension, sign);
}

namespace {

constexpr long max_free_list_length = 100;  ///< free numbers in one list

}  // namespace

std::vector<Expression> read_free_list(const SpecCursor& at, StudyBuilder& draft, Dimension dimension,
                                       const char* count_key,
                                       const std::function<long(const SpecCursor&, long)>& count_numbers) {
  long count = 0;
  const FreeValue free = draft.parameters.evaluate_free(
      at, {{count_key, Presence::required,
            [&](const SpecCursor& c) { count = count_numbers(c, read_integer(c, draft, 1, max_free_list_length)); }}});
  std::vector<Expression> values;
  for (long k = 0; k < count; ++k) {
    const std::string path = fmt::format("{}[{}]", at.path(), k);
    values.push_back(add_free_number(at, path, free, dimension, draft));
    draft.free_numbers.back().is_list_item = true;
  }
  return values;
}

Expression StudyBuilder::add_input(double value) {
  recording->inputs.push_back(value);
  return Expression::input(recording->graph, value);
}

Expression read_duration(const SpecCursor& at, StudyBuilder& draft) {
  const Expression duration = read_number(at, draft, dimension::time, SignConstraint::positive);
  check_duration(at, duration.value());
  return duration;
}

void check_duration(const SpecCursor& at, double duration) {
  if (!trajectory::is_valid_duration(duration))
    at.fail({.expected = trajectory::format_duration_range(), .found = fmt::format("{:.6g} s", duration)});
}

std::vector<Expression> read_numbers(const SpecCursor& at, StudyBuilder& draft, Dimension dimension,
                                     const std::string& what) {
  std::vector<Expression> values;
  read_each(at.items(what), [&](const SpecCursor& item) { values.push_back(read_number(item, draft, dimension)); });
  return values;
}

Vector3E read_vector(const SpecCursor& at, StudyBuilder& draft, Dimension dimension) {
  const std::size_t count = draft.planar() ? 2 : 3;
  Vector3E vector = Vector3E::Zero();
  Eigen::Index i = 0;
  read_each(at.items(vector_form(count), count),
            [&](const SpecCursor& item) { vector[i++] = read_number(item, draft, dimension); });
  return vector;
}

namespace {

Expression max_magnitude(std::span<const Expression> values) {
  Expression largest = 0;
  for (const Expression& value : values) largest = maximum(largest, abs(value));
  return largest;
}

}  // namespace

Vector3E read_direction(const SpecCursor& at, StudyBuilder& draft) {
  const Vector3E direction = read_vector(at, draft, dimension::dimensionless);
  const Expression scale = max_magnitude({direction.data(), 3});
  if (!(scale.value() > 0)) at.fail({.expected = "a direction", .found = "zero"});
  return choose(less(0, scale), normalized(direction / scale), Vector3E(Vector3E::UnitX()));
}

long read_integer(const SpecCursor& at, StudyBuilder& draft, long minimum, long maximum) {
  const std::string what = fmt::format("a whole number from {} to {}", minimum, maximum);
  if (!at.is_scalar()) at.fail_expected(what);
  const double value = draft.parameters.evaluate(at).value();
  if (value != std::round(value) || value < static_cast<double>(minimum) || value > static_cast<double>(maximum))
    at.fail_expected(what);
  return static_cast<long>(value);
}

Matrix3E read_rpy(const SpecCursor& at, StudyBuilder& draft) {
  Vector3E rpy = Vector3E::Zero();
  Eigen::Index i = 0;
  read_each(at.items("[roll, pitch, yaw]", 3),
            [&](const SpecCursor& item) { rpy[i++] = read_number(item, draft, dimension::angle); });
  return rotation_from_rpy(rpy);
}

Matrix3E read_quaternion(const SpecCursor& at, StudyBuilder& draft) {
  at.items("a quaternion [w, x, y, z]", 4);
  std::vector<Expression> q = read_numbers(at, draft, dimension::dimensionless, "a quaternion [w, x, y, z]");
  const Expression scale = max_magnitude(q);
  if (!(scale.value() > 0)) at.fail({.expected = "a quaternion [w, x, y, z] that is not zero", .found = "zero"});
  for (Expression& component : q) component /= scale;
  return choose(less(0, scale), rotation_from_quaternion(q), Matrix3E(Matrix3E::Identity()));
}

}  // namespace balance::specification
