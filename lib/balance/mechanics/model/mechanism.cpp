#include "balance/mechanics/model/mechanism.hpp"

#include "balance/foundation/numerics/extrema.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>

namespace balance {

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

std::string format_position(const double* place, int count, const DisplayUnits& units, double round_off) {
  std::string text;
  for (int i = 0; i < count; ++i) text += (i == 0 ? "(" : ", ") + format_in_unit(place[i], units.length, round_off);
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
  std::vector<Coordinate> all;
  for (std::size_t j = 0; j < joints.size(); ++j) {
    int index = 0;
    for (const CoordinateDefinition& part : coordinate_definitions(joints[j].type))
      all.push_back({joints[j].name + part.suffix, static_cast<int>(j), index++, part.kind});
  }
  return all;
}

bool has_velocity_constraints(const Mechanism& mechanism) {
  return !mechanism.constraints.empty() ||
         std::any_of(mechanism.joints.begin(), mechanism.joints.end(),
                     [](const Joint& joint) { return is_rolling(joint.type) && !joint.slips; });
}

namespace {

/// Between any two of the places. Pairs are tried from the outermost places on, until none of those left can be farther apart.
double largest_distance(std::vector<Vector3> places) {
  Vector3 middle = Vector3::Zero();
  for (const Vector3& place : places) middle += place / static_cast<double>(places.size());
  const auto reach = [&middle](const Vector3& place) { return (place - middle).norm(); };
  std::sort(places.begin(), places.end(), [&](const Vector3& p, const Vector3& q) { return reach(p) > reach(q); });
  double largest = 0;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const double outer = reach(places[i]);
    if (!(2 * outer * (1 + 1e-12) >= largest)) break;
    for (std::size_t j = i + 1; j < places.size(); ++j) {
      if (!((outer + reach(places[j])) * (1 + 1e-12) >= largest)) break;
      largest = std::max(largest, (places[i] - places[j]).norm());
    }
  }
  return largest;
}

}  // namespace

double characteristic_length(const Mechanism& mechanism) {
  double length = 0;
  const std::vector<std::vector<JointId>> joints = joints_of_bodies(mechanism);
  for (std::size_t b = 0; b < mechanism.bodies.size(); ++b) {
    std::vector<Vector3> places;
    for (const NamedPoint& point : mechanism.bodies[b].points) places.push_back(point.position);
    for (const int j : joints[b]) {
      const Joint& joint = mechanism.joints[j];
      if (joint.first == static_cast<int>(b)) places.push_back(joint.point_first);
      if (joint.second == static_cast<int>(b)) places.push_back(joint.point_second);
    }
    if (b != static_cast<std::size_t>(ground)) places.emplace_back(Vector3::Zero());
    length = std::max(length, largest_distance(places));
  }
  for (const Joint& joint : mechanism.joints) length = std::max(length, joint.radius);
  if (length > 0) return length;
  // everything is jointed at one point: then by how far masses are from it
  for (const Body& body : mechanism.bodies)
    if (body.mass > 0)
      length = std::max({length, body.com.norm(), std::sqrt(max_coefficient(body.inertia.diagonal()) / body.mass)});
  for (const Attachment& extra : mechanism.attachments) length = std::max(length, extra.position.norm());
  for (const Disc& disc : mechanism.discs) length = std::max(length, disc.position.norm());
  return length > 0 ? length : 1;
}

double ground_extent(const Mechanism& mechanism) {
  double largest = 1;
  const double length = characteristic_length(mechanism);
  for (const Joint& joint : mechanism.joints)
    for (const int side : {joint.first, joint.second})
      if (side == ground)
        largest = std::max(largest, (side == joint.first ? joint.point_first : joint.point_second).norm() / length);
  return largest;
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
  explicit MechanismUnion(Mechanism first) : whole_(std::move(first)) {}

  void add(const Mechanism& next) {
    if (next.space != whole_.space || next.gravity != whole_.gravity)
      throw std::invalid_argument("mechanisms side by side are in one space with one gravity");
    bodies_ = static_cast<int>(whole_.bodies.size()) - 1;
    coordinates_ = static_cast<int>(whole_.coordinates.size());
    whole_.bodies.insert(whole_.bodies.end(), next.bodies.begin() + 1, next.bodies.end());
    append(whole_.joints, next.joints, [this](Joint& joint) { join(joint.first, joint.second); });
    append(whole_.couplings, next.couplings, [this](Coupling& coupling) {
      coupling.follower += coordinates_;
      shift(coupling.leader);
    });
    append(whole_.attachments, next.attachments, [this](Attachment& one) { one.body = body(one.body); });
    append(whole_.discs, next.discs, [this](Disc& disc) {
      disc.body = body(disc.body);
      shift(disc.follows);
    });
    append(whole_.loads, next.loads, [this](Load& load) { load.body = body(load.body); });
    append(whole_.springs, next.springs, [this](Spring& spring) {
      join(spring.first, spring.second);
      if (spring.is_joint_spring()) spring.coordinate += coordinates_;
    });
    append(whole_.friction, next.friction, [this](Friction& one) { one.coordinate += coordinates_; });
    append(whole_.actuators, next.actuators, [this](CoordinateId& actuator) { actuator += coordinates_; });
    append(whole_.assembly, next.assembly, [this](CoordinateValue& value) { value.coordinate += coordinates_; });
    whole_.coordinates = list_coordinates(whole_.space, whole_.joints);
  }

  Mechanism finish() { return std::move(whole_); }

 private:
  template <class T, class Shift>
  static void append(std::vector<T>& all, const std::vector<T>& more, const Shift& shift) {
    for (T one : more) {
      shift(one);
      all.push_back(std::move(one));
    }
  }
  BodyId body(BodyId one) const { return one == ground ? one : BodyId(one + bodies_); }
  void shift(CoordinateCombination& what) const {
    for (CoordinateTerm& term : what.terms) term.coordinate += coordinates_;
  }
  void join(BodyId& first, BodyId& second) const {
    first = body(first);
    second = body(second);
  }

  Mechanism whole_;
  int bodies_ = 0, coordinates_ = 0;  ///< that stand before the mechanism that is being added
};

}  // namespace

Mechanism disjoint_union(const std::vector<Mechanism>& mechanisms) {
  if (mechanisms.empty()) throw std::invalid_argument("no mechanism to be put side by side");
  MechanismUnion row(mechanisms.front());
  for (std::size_t i = 1; i < mechanisms.size(); ++i) row.add(mechanisms[i]);
  return row.finish();
}

}  // namespace balance
