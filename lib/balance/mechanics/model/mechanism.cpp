#include "balance/mechanics/model/mechanism.hpp"

#include "balance/foundation/numerics/extrema.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>
#include <tuple>

namespace balance::model {

namespace {

std::string format_in_unit(double value, double unit, double round_off) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", std::abs(value) <= round_off ? 0 : value / unit);
  return text;
}

}  // namespace

std::string format_length(double value, const DisplayUnits& units, double round_off) {
  return format_in_unit(value, units.length, round_off) + " " + units.length_name;
}

std::string format_angle(double value, const DisplayUnits& units, double round_off) {
  return format_in_unit(value, units.angle, round_off) + " " + units.angle_name;
}

std::string format_position(const double* position, int count, const DisplayUnits& units, double round_off) {
  std::string text;
  for (int i = 0; i < count; ++i) text += (i == 0 ? "(" : ", ") + format_in_unit(position[i], units.length, round_off);
  return text + ") " + units.length_name;
}

std::vector<std::vector<JointId>> joints_of_bodies(const Mechanism& mechanism) {
  std::vector<std::vector<JointId>> joints(mechanism.bodies.size());
  for (std::size_t j = 0; j < mechanism.joints.size(); ++j) {
    const Joint& joint = mechanism.joints[j];
    joints[joint.first].push_back(static_cast<int>(j));
    if (joint.second != joint.first) joints[joint.second].push_back(static_cast<int>(j));
  }
  return joints;
}

std::vector<std::vector<CoordinateId>> coordinates_of_joints(const Mechanism& mechanism) {
  std::vector<std::vector<CoordinateId>> coordinates(mechanism.joints.size());
  for (std::size_t c = 0; c < mechanism.coordinates.size(); ++c)
    coordinates[mechanism.coordinates[c].joint].push_back(static_cast<int>(c));
  return coordinates;
}

int joint_degrees_of_freedom(JointType type) {
  switch (type) {
    case JointType::fixed: return 0;
    case JointType::revolute:
    case JointType::prismatic: return 1;
    case JointType::pin_slot:
    case JointType::cylindrical:
    case JointType::universal: return 2;
    case JointType::spherical:
    case JointType::planar: return 3;
    case JointType::free: return 6;
    case JointType::rolling_disc:
    case JointType::rolling_sphere: return 5;
  }
  return 0;
}

bool is_rolling(JointType type) { return type == JointType::rolling_disc || type == JointType::rolling_sphere; }

namespace {

struct CoordinateDefinition {
  const char* suffix;
  CoordinateKind kind;
};

std::vector<CoordinateDefinition> coordinate_definitions(JointType type) {
  using enum CoordinateKind;
  switch (type) {
    case JointType::fixed: return {};
    case JointType::revolute: return {{"", angle}};
    case JointType::prismatic: return {{"", length}};
    case JointType::pin_slot: return {{".slide", length}, {".angle", angle}};
    case JointType::cylindrical: return {{".angle", angle}, {".slide", length}};
    case JointType::universal: return {{".1", angle}, {".2", angle}};
    case JointType::spherical: return {{".1", angle}, {".2", angle}, {".3", angle}};
    case JointType::planar: return {{".x", length}, {".y", length}, {".angle", angle}};
    case JointType::free:
      return {{".x", length}, {".y", length}, {".z", length}, {".1", angle}, {".2", angle}, {".3", angle}};
    case JointType::rolling_disc:
      return {{".x", length}, {".y", length}, {".heading", angle}, {".lean", angle}, {".angle", angle}};
    case JointType::rolling_sphere:
      return {{".x", length}, {".y", length}, {".1", angle}, {".2", angle}, {".3", angle}};
  }
  return {};
}

}  // namespace

std::vector<Coordinate> list_coordinates(SpaceKind /*space*/, const std::vector<Joint>& joints) {
  std::vector<Coordinate> coordinates;
  for (std::size_t j = 0; j < joints.size(); ++j) {
    int index = 0;
    for (const CoordinateDefinition& definition : coordinate_definitions(joints[j].type))
      coordinates.push_back({joints[j].name + definition.suffix, static_cast<int>(j), index++, definition.kind});
  }
  return coordinates;
}

bool has_prescribed_speeds(const Mechanism& mechanism) {
  return std::any_of(mechanism.constraints.begin(), mechanism.constraints.end(),
                     [](const GeneralisedSpeed& constraint) { return static_cast<bool>(constraint.value); });
}

bool has_velocity_constraints(const Mechanism& mechanism) {
  return !mechanism.constraints.empty() ||
         std::any_of(mechanism.joints.begin(), mechanism.joints.end(),
                     [](const Joint& joint) { return is_rolling(joint.type) && !joint.slips; });
}

namespace {

/// Largest distance between two of the points. Tries pairs from the outermost points inwards until no remaining pair
/// can exceed the maximum.
double largest_distance(std::vector<Vector3> points) {
  Vector3 centroid = Vector3::Zero();
  for (const Vector3& point : points) centroid += point / static_cast<double>(points.size());
  const auto distance_from_centroid = [&centroid](const Vector3& point) { return (point - centroid).norm(); };
  std::sort(points.begin(), points.end(),
            [&](const Vector3& p, const Vector3& q) { return distance_from_centroid(p) > distance_from_centroid(q); });
  double max_distance = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double radius = distance_from_centroid(points[i]);
    if (!(2 * radius * (1 + 1e-12) >= max_distance)) break;
    for (std::size_t j = i + 1; j < points.size(); ++j) {
      if (!((radius + distance_from_centroid(points[j])) * (1 + 1e-12) >= max_distance)) break;
      max_distance = std::max(max_distance, (points[i] - points[j]).norm());
    }
  }
  return max_distance;
}

}  // namespace

double characteristic_length(const Mechanism& mechanism) {
  double length = 0;
  const std::vector<std::vector<JointId>> joints = joints_of_bodies(mechanism);
  for (std::size_t b = 0; b < mechanism.bodies.size(); ++b) {
    std::vector<Vector3> points;
    for (const NamedPoint& point : mechanism.bodies[b].points) points.push_back(point.position);
    for (const int j : joints[b]) {
      const Joint& joint = mechanism.joints[j];
      if (joint.first == static_cast<int>(b)) points.push_back(joint.point_first);
      if (joint.second == static_cast<int>(b)) points.push_back(joint.point_second);
    }
    if (b != static_cast<std::size_t>(ground)) points.emplace_back(Vector3::Zero());
    length = std::max(length, largest_distance(points));
  }
  for (const Joint& joint : mechanism.joints) length = std::max(length, joint.radius);
  if (length > 0) return length;
  // all joints coincide: use the distances of the masses from that point
  for (const Body& body : mechanism.bodies)
    if (body.mass > 0)
      length = std::max(
          {length, body.com.norm(), std::sqrt(numerics::max_coefficient(body.inertia.diagonal()) / body.mass)});
  for (const Attachment& attachment : mechanism.attachments) length = std::max(length, attachment.position.norm());
  for (const Disc& disc : mechanism.discs) length = std::max(length, disc.position.norm());
  return length > 0 ? length : 1;
}

double ground_extent(const Mechanism& mechanism) {
  double extent = 1;
  const double length = characteristic_length(mechanism);
  for (const Joint& joint : mechanism.joints)
    for (const int side : {joint.first, joint.second})
      if (side == ground)
        extent = std::max(extent, (side == joint.first ? joint.point_first : joint.point_second).norm() / length);
  return extent;
}

double total_mass(const Mechanism& mechanism) {
  double mass = 0;
  for (const Body& body : mechanism.bodies) mass += body.mass;
  for (const Attachment& attachment : mechanism.attachments) mass += attachment.mass;
  for (const Disc& disc : mechanism.discs) mass += disc.mass;
  return mass;
}

namespace {

/// The lists that a union concatenates, but for the bodies, which share the ground.
constexpr std::tuple element_lists{&Mechanism::joints,      &Mechanism::couplings,      &Mechanism::constraints,
                                   &Mechanism::attachments, &Mechanism::discs,          &Mechanism::loads,
                                   &Mechanism::springs,     &Mechanism::force_elements, &Mechanism::friction,
                                   &Mechanism::actuators,   &Mechanism::assembly};

/// Adds to all indices of bodies, but the ground's, and of coordinates.
void shift_indices(Mechanism& mechanism, int bodies, int coordinates) {
  const auto shift_body = [&](BodyId& body) {
    if (body != ground) body += bodies;
  };
  const auto shift_leader = [&](CoordinateCombination& combination) {
    for (CoordinateTerm& term : combination.terms) term.coordinate += coordinates;
  };
  for (Joint& joint : mechanism.joints) shift_body(joint.first), shift_body(joint.second);
  for (Coupling& coupling : mechanism.couplings) coupling.follower += coordinates, shift_leader(coupling.leader);
  for (GeneralisedSpeed& speed : mechanism.constraints)
    for (GeneralisedSpeedTerm& term : speed.terms) {
      shift_body(term.body);
      if (term.kind == GeneralisedSpeedTerm::Kind::coordinate) term.index += coordinates;
    }
  for (Attachment& attachment : mechanism.attachments) shift_body(attachment.body);
  for (Disc& disc : mechanism.discs) shift_body(disc.body), shift_leader(disc.follows);
  for (Load& load : mechanism.loads) {
    shift_body(load.body);
    if (load.is_over_coordinate()) load.coordinate += coordinates;
  }
  for (Spring& spring : mechanism.springs) {
    shift_body(spring.first), shift_body(spring.second);
    if (spring.is_joint_spring()) spring.coordinate += coordinates;
  }
  for (ForceElement& element : mechanism.force_elements) {
    shift_body(element.first), shift_body(element.second);
    if (element.is_in_joint()) element.coordinate += coordinates;
  }
  for (Friction& friction : mechanism.friction) friction.coordinate += coordinates;
  for (CoordinateId& actuator : mechanism.actuators) actuator += coordinates;
  for (CoordinateValue& value : mechanism.assembly) value.coordinate += coordinates;
}

template <class T>
void append(std::vector<T>& target, const std::vector<T>& items) {
  target.insert(target.end(), items.begin(), items.end());
}

}  // namespace

Mechanism disjoint_union(const std::vector<Mechanism>& mechanisms) {
  if (mechanisms.empty()) throw std::invalid_argument("no mechanisms to put side by side");
  Mechanism united = mechanisms.front();
  for (std::size_t i = 1; i < mechanisms.size(); ++i) {
    Mechanism next = mechanisms[i];
    if (next.space != united.space || next.gravity != united.gravity)
      throw std::invalid_argument("mechanisms side by side must share space and gravity");
    shift_indices(next, static_cast<int>(united.bodies.size()) - 1, static_cast<int>(united.coordinates.size()));
    united.bodies.insert(united.bodies.end(), next.bodies.begin() + 1, next.bodies.end());
    std::apply([&](const auto... list) { (append(united.*list, next.*list), ...); }, element_lists);
    united.coordinates = list_coordinates(united.space, united.joints);
  }
  if (mechanisms.size() > 1) united.torque_distribution.reset();
  return united;
}

Mechanism extract_part(const Mechanism& united, const Mechanism& like, std::size_t part) {
  const std::size_t bodies = like.bodies.size() - 1, parts = (united.bodies.size() - 1) / bodies;
  const auto slice = [&](auto list) {
    const auto size = static_cast<std::ptrdiff_t>((united.*list).size() / parts);
    const auto begin = (united.*list).begin() + static_cast<std::ptrdiff_t>(part) * size;
    return std::vector(begin, begin + size);
  };
  Mechanism extracted = like;
  const auto first_body = united.bodies.begin() + 1 + static_cast<std::ptrdiff_t>(part * bodies);
  std::copy(first_body, first_body + static_cast<std::ptrdiff_t>(bodies), extracted.bodies.begin() + 1);
  std::apply([&](const auto... list) { ((extracted.*list = slice(list)), ...); }, element_lists);
  shift_indices(extracted, -static_cast<int>(part * bodies), -static_cast<int>(part * like.coordinates.size()));
  if (extracted.tool)
    for (const NamedPoint& point : extracted.bodies[static_cast<std::size_t>(extracted.tool->body)].points)
      if (point.name == extracted.tool->point) extracted.tool->position = point.position;
  return extracted;
}

}  // namespace balance::model
