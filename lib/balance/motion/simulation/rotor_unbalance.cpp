#include "balance/motion/simulation/rotor_unbalance.hpp"

#include "balance/foundation/base/elementary.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <variant>

namespace balance::simulation {

namespace {

/// Relative to the sum of the magnitudes of its terms: what is left of an unbalance that cancels.
constexpr double unbalance_round_off = 1e-12;
/// Relative to the mechanism's size: distance of planes that are the same.
constexpr double plane_tolerance = 1e-9;
/// ISO 21940-11: share of the permissible residual unbalance in one of two planes.
constexpr double min_plane_share = 0.3;
/// ISO 21940-11, table 1 [mm/s].
constexpr std::array balance_quality_grades = {0.4, 1.0, 2.5, 6.3, 16.0, 40.0, 100.0, 250.0, 630.0, 1600.0, 4000.0};
constexpr double millimetres = 1000;

/// The rotor's axis in its body's axes.
struct RotorAxis {
  BodyId body = 0;
  Vector3 point = Vector3::Zero(), direction = Vector3::UnitZ();
  Vector3 first = Vector3::UnitX(), second = Vector3::UnitY();  ///< perpendicular to it; angles count from `first`
  std::string reference = "x";

  double position(const Vector3& place) const { return direction.dot(place - point); }
};

void choose_angle_reference(RotorAxis& axis) {
  constexpr double max_cosine = 0.9;  // of a reference axis and the rotor's
  const bool is_along_x = std::abs(axis.direction.x()) > max_cosine;
  const Vector3 reference = is_along_x ? Vector3::UnitY() : Vector3::UnitX();
  axis.reference = is_along_x ? "y" : "x";
  axis.first = (reference - axis.direction.dot(reference) * axis.direction).normalized();
  axis.second = axis.direction.cross(axis.first);
}

/// The axis of the body that a joint connects with the ground, if it is a revolute one.
std::optional<RotorAxis> find_rotor_axis(const Joint& joint) {
  if (joint.type != JointType::revolute || (joint.first == model::ground) == (joint.second == model::ground))
    return std::nullopt;
  RotorAxis axis;
  const bool is_second = joint.first == model::ground;
  axis.body = is_second ? joint.second : joint.first;
  axis.point = is_second ? joint.point_second : joint.point_first;
  axis.direction = is_second ? Vector3(joint.rotation.transpose() * joint.axis) : joint.axis;
  choose_angle_reference(axis);
  return axis;
}

/// Masses about the axis' point with the sums of the terms' magnitudes.
struct MassMoments {
  double mass = 0;
  Vector3 first = Vector3::Zero();   ///< ∫ r dm
  Matrix3 second = Matrix3::Zero();  ///< ∫ r rᵀ dm
  double first_size = 0, second_size = 0;

  /// @param inertia about the centre of mass
  void add(double m, const Vector3& place, const Matrix3& inertia) {
    mass += m;
    first += m * place;
    first_size += std::abs(m) * place.norm();
    second += m * place * place.transpose() + 0.5 * inertia.trace() * Matrix3::Identity() - inertia;
    second_size += std::abs(m) * place.squaredNorm() + inertia.norm();
  }
};

/// Inertia about the centre of mass, averaged over the disc's turn about its own axis.
Matrix3 average_inertia(const Disc& disc) {
  const double about_axis = disc.axis.dot(disc.inertia * disc.axis);
  const double across = 0.5 * (disc.inertia.trace() - about_axis);
  return across * Matrix3::Identity() + (about_axis - across) * disc.axis * disc.axis.transpose();
}

MassMoments sum_masses(const Mechanism& mechanism, const RotorAxis& axis) {
  MassMoments sum;
  const Body& body = mechanism.bodies[static_cast<std::size_t>(axis.body)];
  sum.add(body.mass, body.com - axis.point, body.inertia);
  for (const Attachment& attachment : mechanism.attachments)
    if (attachment.body == axis.body) sum.add(attachment.mass, attachment.position - axis.point, attachment.inertia);
  for (const Disc& disc : mechanism.discs)
    if (disc.body == axis.body) sum.add(disc.mass, disc.position - axis.point, average_inertia(disc));
  return sum;
}

UnbalanceVector make_unbalance(const RotorAxis& axis, const Vector3& vector, double size) {
  const auto component = [&](const Vector3& direction) {
    const double value = direction.dot(vector);
    return std::abs(value) <= unbalance_round_off * size ? 0 : value;
  };
  const double x = component(axis.first), y = component(axis.second);
  UnbalanceVector unbalance{std::sqrt(x * x + y * y), 0};
  if (unbalance.magnitude == 0) return {};
  unbalance.angle = elementary::atan2(y, x);
  if (unbalance.angle < 0) unbalance.angle += 2 * std::numbers::pi;
  return unbalance;
}

/// Adds a name to the plane at that position, or a new plane.
void add_to_plane(std::vector<CorrectionPlane>& planes, const std::string& name, double position, double tolerance) {
  for (CorrectionPlane& plane : planes)
    if (std::abs(plane.position - position) <= tolerance) {
      plane.name += ", " + name;
      return;
    }
  planes.push_back({.name = name, .position = position});
}

/// Planes without their unbalances; none unless there are two.
/// @param tolerance of their positions [m]
std::vector<CorrectionPlane> list_planes(const Mechanism& mechanism, const RotorAxis& axis, double tolerance) {
  std::vector<CorrectionPlane> of_counterweights, of_points;
  for (const Attachment& attachment : mechanism.attachments)
    if (attachment.body == axis.body && attachment.kind == AttachmentKind::counterweight)
      add_to_plane(of_counterweights, attachment.name, axis.position(attachment.position), tolerance);
  if (of_counterweights.size() == 2) return of_counterweights;
  for (const model::NamedPoint& point : mechanism.bodies[static_cast<std::size_t>(axis.body)].points)
    add_to_plane(of_points, point.name, axis.position(point.position), tolerance);
  return of_points.size() == 2 ? of_points : std::vector<CorrectionPlane>();
}

/// U₁ + U₂ = U, z₁ U₁ + z₂ U₂ = D, both about the axis' point.
void resolve_in_planes(const RotorAxis& axis, const MassMoments& sum, std::vector<CorrectionPlane>& planes) {
  if (planes.size() != 2) return;
  const double z1 = planes[0].position, z2 = planes[1].position, distance = z2 - z1;
  const Vector3 D = sum.second * axis.direction;
  const double size = (sum.second_size + (std::abs(z1) + std::abs(z2)) * sum.first_size) / std::abs(distance);
  planes[0].unbalance = make_unbalance(axis, (z2 * sum.first - D) / distance, size);
  planes[1].unbalance = make_unbalance(axis, (D - z1 * sum.first) / distance, size);
  const double centre = axis.direction.dot(sum.first) / sum.mass, share = (z2 - centre) / distance;
  const bool is_inboard = share >= 0 && share <= 1;
  planes[0].share = is_inboard ? std::clamp(share, min_plane_share, 1 - min_plane_share) : 0.5;
  planes[1].share = 1 - planes[0].share;
}

/// The constant speed at which a trajectory turns a coordinate; 0: it does not.
double find_constant_speed(const Trajectory& trajectory, CoordinateId coordinate) {
  if (trajectory.law.kind != MotionLawKind::uniform || trajectory.drive != DriveKind::joints ||
      !std::holds_alternative<trajectory::LinePath>(trajectory.path) || !(trajectory.duration > 0))
    return 0;
  double change = 0;
  for (const CoordinateValue& value : trajectory.from.joints)
    if (value.coordinate == coordinate) change -= value.value;
  for (const CoordinateValue& value : trajectory.to.joints)
    if (value.coordinate == coordinate) change += value.value;
  return std::abs(change) / trajectory.duration;
}

RotorQuality rate_quality(const RotorUnbalance& rotor, const std::string& trajectory, double speed) {
  RotorQuality quality{.trajectory = trajectory, .speed = speed, .quality = rotor.eccentricity * speed * millimetres};
  for (const CorrectionPlane& plane : rotor.planes) {
    const double of_plane = plane.unbalance.magnitude / (rotor.mass * plane.share) * speed * millimetres;
    quality.quality = &plane == &rotor.planes.front() ? of_plane : std::max(quality.quality, of_plane);
  }
  if (!std::isfinite(quality.quality)) return quality;
  const auto grade = std::lower_bound(balance_quality_grades.begin(), balance_quality_grades.end(), quality.quality);
  quality.grade = grade == balance_quality_grades.end() ? 0 : *grade;
  return quality;
}

RotorUnbalance measure_rotor(const Mechanism& mechanism, const std::vector<Trajectory>& trajectories,
                             const Joint& joint, CoordinateId coordinate, const RotorAxis& axis, double tolerance) {
  const MassMoments sum = sum_masses(mechanism, axis);
  RotorUnbalance rotor{.body = mechanism.bodies[static_cast<std::size_t>(axis.body)].name,
                       .joint = joint.name,
                       .mass = sum.mass,
                       .angle_reference = axis.reference,
                       .static_unbalance = make_unbalance(axis, sum.first, sum.first_size),
                       .is_spatial = mechanism.space == SpaceKind::spatial};
  if (!(sum.mass > 0)) return rotor;
  rotor.eccentricity = rotor.static_unbalance.magnitude / sum.mass;
  if (rotor.is_spatial) {
    const double centre = axis.direction.dot(sum.first) / sum.mass;
    rotor.couple_unbalance = make_unbalance(axis, sum.second * axis.direction - centre * sum.first,
                                            sum.second_size + std::abs(centre) * sum.first_size);
    rotor.planes = list_planes(mechanism, axis, tolerance);
    resolve_in_planes(axis, sum, rotor.planes);
  }
  for (const Trajectory& trajectory : trajectories)
    if (const double speed = find_constant_speed(trajectory, coordinate); speed > 0)
      rotor.qualities.push_back(rate_quality(rotor, trajectory.name, speed));
  return rotor;
}

}  // namespace

std::vector<RotorUnbalance> list_rotor_unbalances(const Mechanism& mechanism,
                                                  const std::vector<Trajectory>& trajectories) {
  const std::vector<std::vector<JointId>> joints_of_body = joints_of_bodies(mechanism);
  const std::vector<std::vector<CoordinateId>> coordinates = coordinates_of_joints(mechanism);
  const double tolerance = plane_tolerance * characteristic_length(mechanism);  // quadratic in the points
  std::vector<RotorUnbalance> rotors;
  for (std::size_t j = 0; j < mechanism.joints.size(); ++j) {
    const std::optional<RotorAxis> axis = find_rotor_axis(mechanism.joints[j]);
    if (!axis || joints_of_body[static_cast<std::size_t>(axis->body)].size() != 1) continue;
    RotorUnbalance rotor =
        measure_rotor(mechanism, trajectories, mechanism.joints[j], coordinates[j].front(), *axis, tolerance);
    if (rotor.mass > 0) rotors.push_back(std::move(rotor));
  }
  return rotors;
}

std::vector<std::string> list_rotor_names(const Mechanism& mechanism) {
  const std::vector<std::vector<JointId>> joints_of_body = joints_of_bodies(mechanism);
  std::vector<std::string> names;
  for (const Joint& joint : mechanism.joints)
    if (const std::optional<RotorAxis> axis = find_rotor_axis(joint);
        axis && joints_of_body[static_cast<std::size_t>(axis->body)].size() == 1)
      names.push_back(mechanism.bodies[static_cast<std::size_t>(axis->body)].name);
  return names;
}

double compute_rotor_quality(const Mechanism& mechanism, const Trajectory& trajectory, const std::string& body) {
  for (const RotorUnbalance& rotor : list_rotor_unbalances(mechanism, {trajectory})) {
    if (rotor.body != body) continue;
    if (rotor.qualities.empty())
      throw std::invalid_argument("'" + trajectory.name + "' does not turn " + body + " at a constant speed");
    return rotor.qualities.front().quality;
  }
  throw std::invalid_argument(body + " is no rotor with a mass: its only joint must be a revolute one with the ground");
}

}  // namespace balance::simulation
