#include "balance/mechanics/model/mechanism.hpp"

#include "balance/foundation/numerics/extrema.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>

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

class MechanismUnion {
 public:
  explicit MechanismUnion(Mechanism first) : union_(std::move(first)) {}

  void add(const Mechanism& next) {
    if (next.space != union_.space || next.gravity != union_.gravity)
      throw std::invalid_argument("mechanisms side by side must share space and gravity");
    body_offset_ = static_cast<int>(union_.bodies.size()) - 1;
    coordinate_offset_ = static_cast<int>(union_.coordinates.size());
    union_.bodies.insert(union_.bodies.end(), next.bodies.begin() + 1, next.bodies.end());
    append(union_.joints, next.joints, [this](Joint& joint) { shift_bodies(joint.first, joint.second); });
    append(union_.couplings, next.couplings, [this](Coupling& coupling) {
      coupling.follower += coordinate_offset_;
      shift(coupling.leader);
    });
    append(union_.constraints, next.constraints, [this](GeneralisedSpeed& speed) {
      for (GeneralisedSpeedTerm& term : speed.terms) {
        term.body = body(term.body);
        if (term.kind == GeneralisedSpeedTerm::Kind::coordinate) term.index += coordinate_offset_;
      }
    });
    append(union_.attachments, next.attachments,
           [this](Attachment& attachment) { attachment.body = body(attachment.body); });
    append(union_.discs, next.discs, [this](Disc& disc) {
      disc.body = body(disc.body);
      shift(disc.follows);
    });
    append(union_.loads, next.loads, [this](Load& load) { load.body = body(load.body); });
    append(union_.springs, next.springs, [this](Spring& spring) {
      shift_bodies(spring.first, spring.second);
      if (spring.is_joint_spring()) spring.coordinate += coordinate_offset_;
    });
    append(union_.friction, next.friction, [this](Friction& friction) { friction.coordinate += coordinate_offset_; });
    append(union_.actuators, next.actuators, [this](CoordinateId& actuator) { actuator += coordinate_offset_; });
    append(union_.assembly, next.assembly, [this](CoordinateValue& value) { value.coordinate += coordinate_offset_; });
    union_.coordinates = list_coordinates(union_.space, union_.joints);
    union_.torque_distribution.reset();
  }

  Mechanism finish() { return std::move(union_); }

 private:
  template <class T, class Shift>
  static void append(std::vector<T>& target, const std::vector<T>& items, const Shift& shift) {
    for (T item : items) {
      shift(item);
      target.push_back(std::move(item));
    }
  }
  BodyId body(BodyId id) const { return id == ground ? id : BodyId(id + body_offset_); }
  void shift(CoordinateCombination& combination) const {
    for (CoordinateTerm& term : combination.terms) term.coordinate += coordinate_offset_;
  }
  void shift_bodies(BodyId& first, BodyId& second) const {
    first = body(first);
    second = body(second);
  }

  Mechanism union_;
  int body_offset_ = 0, coordinate_offset_ = 0;  ///< index offsets of the mechanism being added
};

}  // namespace

Mechanism disjoint_union(const std::vector<Mechanism>& mechanisms) {
  if (mechanisms.empty()) throw std::invalid_argument("no mechanisms to put side by side");
  MechanismUnion combined(mechanisms.front());
  for (std::size_t i = 1; i < mechanisms.size(); ++i) combined.add(mechanisms[i]);
  return combined.finish();
}

}  // namespace balance::model
