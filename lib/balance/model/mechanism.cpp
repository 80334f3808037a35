#include "balance/model/mechanism.hpp"

#include "balance/base/extrema.hpp"
#include "balance/model/incidence.hpp"

#include <algorithm>
#include <cmath>

namespace balance {

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

}  // namespace balance
