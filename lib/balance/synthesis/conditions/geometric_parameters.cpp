#include "balance/synthesis/conditions/geometric_parameters.hpp"
#include "balance/foundation/base/elementary.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <tuple>
#include <utility>

namespace balance::conditions {

namespace {

using Kind = GeometricParameterLocation::Kind;

std::size_t as_index(int index) { return static_cast<std::size_t>(index); }

/// Collects numbers; a named point has one entry per axis.
class GeometricParameterList {
 public:
  explicit GeometricParameterList(const Mechanism& mechanism) : mechanism_(mechanism) {}

  void add(const std::string& label, const std::string& unit, const GeometricParameterLocation& location) {
    numbers_.push_back({label, unit, geometric_value_at(mechanism_, location), {location}});
  }

  /// Adds a position on a body: one of its named points, or an unnamed point.
  void add_point(BodyId body, const Vector3& position, GeometricParameterLocation location,
                 const std::string& fallback_label) {
    const int axes = mechanism_.space == SpaceKind::planar ? 2 : 3;
    const std::optional<int> point = find_point(body, position);
    for (location.axis = 0; location.axis < axes; ++location.axis) {
      const std::string axis(1, "xyz"[location.axis]);
      if (!point) {
        add(fallback_label + "." + axis, "m", location);
        continue;
      }
      const auto [entry, is_new] = named_.try_emplace({body, *point, location.axis}, numbers_.size());
      if (is_new) {
        const Body& owner = mechanism_.bodies[as_index(body)];
        add(owner.name + "." + owner.points[as_index(*point)].name + "." + axis, "m",
            {Kind::body_point, body, *point, location.axis});
      }
      numbers_[entry->second].locations.push_back(location);
    }
  }

  /// Adds the ratios of a belt over several joints.
  void add_terms(const model::CoordinateCombination& followed, const std::string& owner,
                 GeometricParameterLocation location) {
    if (followed.terms.size() < 2) return;
    for (; location.item < static_cast<int>(followed.terms.size()); ++location.item) {
      const CoordinateId coordinate = followed.terms[as_index(location.item)].coordinate;
      add(owner + "." + mechanism_.coordinates[as_index(coordinate)].name + ".ratio", "1", location);
    }
  }

  /// Adds points, and factors other than ±1.
  void add_constraint(const model::GeneralisedSpeed& constraint, int index) {
    for (int item = 0; item < static_cast<int>(constraint.terms.size()); ++item) {
      const model::GeneralisedSpeedTerm& term = constraint.terms[as_index(item)];
      const std::string name = constraint.name + "[" + std::to_string(item) + "]";
      if (std::abs(term.factor) != 1) add(name, "1", {Kind::constraint_factor, index, item, 0});
      using enum model::GeneralisedSpeedTerm::Kind;
      if (term.kind == velocity || term.kind == velocity_body)
        add_point(term.body, term.position, {Kind::constraint_point, index, item, 0}, name + ".at");
    }
  }

  std::vector<GeometricParameter> finish() { return std::move(numbers_); }

 private:
  std::optional<int> find_point(BodyId body, const Vector3& position) const {
    const auto& points = mechanism_.bodies[as_index(body)].points;
    for (std::size_t i = 0; i < points.size(); ++i)
      if (points[i].position == position) return static_cast<int>(i);
    return std::nullopt;
  }

  const Mechanism& mechanism_;
  std::vector<GeometricParameter> numbers_;
  std::map<std::tuple<int, int, int>, std::size_t> named_;  // body, point, axis -> index in numbers_
};

void add_gravity(const Mechanism& mechanism, std::vector<GeometricParameter>& numbers) {
  GeometricParameter g{"g", "m/s^2", mechanism.gravity.norm(), {}};
  for (int axis = 0; axis < 3; ++axis) g.locations.push_back({Kind::gravity, 0, 0, axis});
  numbers.push_back(std::move(g));
}

}  // namespace

std::vector<GeometricParameter> list_geometric_parameters(const Mechanism& m) {
  GeometricParameterList list(m);
  for (std::size_t j = 0; j < m.joints.size(); ++j) {
    const Joint& joint = m.joints[j];
    const int index = static_cast<int>(j);
    list.add_point(joint.first, joint.point_first, {Kind::joint_first, index, 0, 0}, joint.name + ".first");
    list.add_point(joint.second, joint.point_second, {Kind::joint_second, index, 0, 0}, joint.name + ".second");
    if (is_rolling(joint.type)) list.add(joint.name + ".radius", "m", {Kind::joint_radius, index, 0, 0});
  }
  for (std::size_t c = 0; c < m.constraints.size(); ++c) list.add_constraint(m.constraints[c], static_cast<int>(c));
  if (m.tool) list.add_point(m.tool->body, m.tool->position, {Kind::tool, 0, 0, 0}, "tool");
  for (std::size_t d = 0; d < m.discs.size(); ++d) {
    const int index = static_cast<int>(d);
    list.add_point(m.discs[d].body, m.discs[d].position, {Kind::disc, index, 0, 0}, m.discs[d].name + ".at");
    list.add(m.discs[d].name + ".ratio", "1", {Kind::disc_ratio, index, 0, 0});
    list.add_terms(m.discs[d].follows, m.discs[d].name, {Kind::disc_term_ratio, index, 0, 0});
  }
  for (std::size_t c = 0; c < m.couplings.size(); ++c) {
    const std::string& name = m.coordinates[as_index(m.couplings[c].follower)].name;
    list.add(name + ".ratio", "1", {Kind::coupling_ratio, static_cast<int>(c), 0, 0});
    list.add_terms(m.couplings[c].leader, name, {Kind::coupling_term_ratio, static_cast<int>(c), 0, 0});
  }
  for (std::size_t s = 0; s < m.springs.size(); ++s) {
    const Spring& spring = m.springs[s];
    if (spring.is_joint_spring()) continue;
    const int index = static_cast<int>(s);
    list.add_point(spring.first, spring.point_first, {Kind::spring_first, index, 0, 0}, spring.name + ".first");
    list.add_point(spring.second, spring.point_second, {Kind::spring_second, index, 0, 0}, spring.name + ".second");
    list.add(spring.name + ".free_length", "m", {Kind::free_length, index, 0, 0});
  }
  for (std::size_t l = 0; l < m.loads.size(); ++l)
    list.add_point(m.loads[l].body, m.loads[l].point, {Kind::load, static_cast<int>(l), 0, 0}, m.loads[l].name + ".at");
  std::vector<GeometricParameter> numbers = list.finish();
  add_gravity(m, numbers);
  return numbers;
}

namespace {

/// Whether every joint moves its bodies only in planes normal to this axis of both.
bool is_planar_normal_to(const Mechanism& mechanism, int axis) {
  const Vector3 normal = Vector3::Unit(axis);
  constexpr double parallel_tolerance = 1e-12;
  for (const Joint& joint : mechanism.joints) {
    const bool is_revolute = joint.type == JointType::revolute, is_prismatic = joint.type == JointType::prismatic;
    if (!is_revolute && !is_prismatic && joint.type != JointType::fixed) return false;
    if (is_revolute && joint.axis.cross(normal).norm() > parallel_tolerance) return false;
    if (is_prismatic && std::abs(joint.axis.dot(normal)) > parallel_tolerance) return false;
    if ((joint.rotation * normal).cross(normal).norm() > parallel_tolerance) return false;
  }
  return true;
}

/// The axis normal to all motion; std::nullopt if there is none.
std::optional<int> find_common_axis(const Mechanism& mechanism) {
  if (mechanism.space == SpaceKind::planar) return 2;
  for (const int axis : {2, 0, 1})
    if (is_planar_normal_to(mechanism, axis)) return axis;
  return std::nullopt;
}

}  // namespace

std::vector<PolarPoint> list_polar_points(const Mechanism& mechanism) {
  std::vector<PolarPoint> points;
  const std::optional<int> normal_axis = find_common_axis(mechanism);
  if (!normal_axis) return points;
  const char first = "yzx"[*normal_axis], second = "zxy"[*normal_axis];
  const std::vector<GeometricParameter> numbers = list_geometric_parameters(mechanism);
  for (const GeometricParameter& x : numbers) {
    if (x.label.size() < 2 || x.label[x.label.size() - 2] != '.' || x.label.back() != first || x.value == 0) continue;
    const std::string name = x.label.substr(0, x.label.size() - 1);
    const auto y = std::find_if(numbers.begin(), numbers.end(),
                                [&](const GeometricParameter& other) { return other.label == name + second; });
    if (y == numbers.end() || y->value == 0 || y->locations.size() != x.locations.size()) continue;
    PolarPoint point{{name + "r", "m", std::hypot(x.value, y->value), {}},
                     {name + "angle", "rad", elementary::atan2(y->value, x.value), {}},
                     x.label,
                     y->label};
    for (std::size_t p = 0; p < x.locations.size(); ++p) {
      point.distance.locations.push_back(x.locations[p]);
      point.distance.locations.push_back(y->locations[p]);
    }
    point.angle.locations = point.distance.locations;
    points.push_back(std::move(point));
  }
  return points;
}

Mechanism rotate_point_direction(const Mechanism& mechanism, const GeometricParameter& angle, double rotation) {
  Mechanism result = mechanism;
  const double c = elementary::cos(rotation), s = elementary::sin(rotation);
  for (std::size_t p = 0; p + 1 < angle.locations.size(); p += 2) {
    const double x = geometric_value_at(mechanism, angle.locations[p]),
                 y = geometric_value_at(mechanism, angle.locations[p + 1]);
    geometric_value_at(result, angle.locations[p]) = c * x - s * y;
    geometric_value_at(result, angle.locations[p + 1]) = s * x + c * y;
  }
  return result;
}

double geometric_value(const Mechanism& mechanism, const GeometricParameter& number) {
  if (number.locations.front().kind == Kind::gravity) return mechanism.gravity.norm();
  return geometric_value_at(mechanism, number.locations.front());
}

Mechanism scale_geometric_parameter(const Mechanism& mechanism, const GeometricParameter& number, double factor) {
  Mechanism result = mechanism;
  for (const GeometricParameterLocation& location : number.locations) geometric_value_at(result, location) *= factor;
  return result;
}

}  // namespace balance::conditions
