#include "transforms.hpp"

#include <algorithm>
#include <cmath>

namespace laws {

using namespace balance;
using namespace balance::model;
using namespace balance::trajectory;

namespace {

void displace(PoseTarget& pose, const Matrix3& R, const Vector3& d) {
  if (pose.tool) pose.tool = R * *pose.tool + d;
  if (pose.com) pose.com = R * *pose.com + d;
  if (pose.orientation) pose.orientation = R * *pose.orientation;
  if (pose.angle) *pose.angle += std::atan2(R(1, 0), R(0, 0));
}

void displace(Path& path, const Matrix3& R, const Vector3& d) {
  if (auto* circle = std::get_if<CirclePath>(&path)) {
    circle->centre = R * circle->centre + d;
    circle->normal = R * circle->normal;
  }
  if (auto* arc = std::get_if<ArcPath>(&path)) arc->via = R * arc->via + d;
  if (auto* way = std::get_if<WaypointPath>(&path))
    for (PoseTarget& point : way->points) displace(point, R, d);
}

void displace_ground(Joint& joint, const Matrix3& R, const Vector3& d) {
  if (joint.first == ground) {
    joint.point_first = R * joint.point_first + d;
    joint.axis = R * joint.axis;
    joint.axis2 = R * joint.axis2;
    joint.rotation = R * joint.rotation;
  }
  if (joint.second == ground) {
    joint.point_second = R * joint.point_second + d;
    joint.rotation = joint.rotation * R.transpose();
  }
}

template <class T>
void scale(PoseTargetOf<T>& pose, const MechanismOf<T>& m, double length) {
  if (pose.tool) *pose.tool *= length;
  if (pose.com) *pose.com *= length;
  for (auto& joint : pose.joints)
    if (m.coordinates[joint.coordinate].kind == CoordinateKind::length) joint.value *= length;
}

template <class T>
void scale(PathOf<T>& path, const MechanismOf<T>& m, double length) {
  if (auto* circle = std::get_if<CirclePathOf<T>>(&path)) circle->centre *= length;
  if (auto* arc = std::get_if<ArcPathOf<T>>(&path)) arc->via *= length;
  if (auto* way = std::get_if<WaypointPathOf<T>>(&path))
    for (auto& point : way->points) scale(point, m, length);
}

template <class T>
void scale_masses(MechanismOf<T>& m, const Units& by) {
  const double L = by.length, inertia = by.mass * L * L;
  for (auto& body : m.bodies) {
    body.mass *= by.mass, body.com *= L, body.inertia *= inertia;
    for (auto& point : body.points) point.position *= L;
  }
  for (auto& extra : m.attachments) extra.mass *= by.mass, extra.position *= L, extra.inertia *= inertia;
  for (auto& disc : m.discs) {
    disc.mass *= by.mass, disc.position *= L, disc.inertia *= inertia;
    for (auto& term : disc.follows.terms)
      if (m.coordinates[term.coordinate].kind == CoordinateKind::length) term.ratio /= L;
  }
}

template <class T>
void scale_forces(MechanismOf<T>& m, const Units& by) {
  const double L = by.length;
  for (auto& load : m.loads) {
    load.point *= L;
    const bool over_length = load.is_over_coordinate() && m.coordinates[load.coordinate].kind == CoordinateKind::length;
    for (T& argument : load.arguments) argument *= load.is_over_time() ? by.time : over_length ? L : 1;
    for (auto& force : load.force) force *= by.force();
    for (auto& moment : load.moment) moment *= by.moment();
  }
  for (auto& spring : m.springs) {
    spring.point_first *= L, spring.point_second *= L, spring.free_length *= L;
    for (auto* length : {&spring.slack_length, &spring.shortest_length, &spring.longest_length})
      if (*length) **length *= L;
    const bool turns = spring.is_joint_spring() && m.coordinates[spring.coordinate].kind == CoordinateKind::angle;
    spring.stiffness *= turns ? by.moment() : by.force() / L;
    spring.preload *= turns ? by.moment() : by.force();
  }
  for (auto& element : m.force_elements) {
    element.point_first *= L, element.point_second *= L;
    element.damping *= by.force() / L * by.time;
    const bool turns = element.is_in_joint() && m.coordinates[element.coordinate].kind == CoordinateKind::angle;
    for (T& displacement : element.table.displacement)
      if (!turns) displacement *= L;
    for (T& force : element.table.force) force *= turns ? by.moment() : by.force();
  }
  for (auto& friction : m.friction) {
    const bool length = m.coordinates[friction.coordinate].kind == CoordinateKind::length;
    const double effort = length ? by.force() : by.moment();
    friction.coulomb *= effort;
    for (auto* other : {&friction.breakaway, &friction.coulomb_backward, &friction.at_rest_backward})
      if (*other) **other *= effort;
    friction.viscous *= (length ? by.force() / L : by.moment()) * by.time;
  }
}

template <class T>
void scale_geometry(MechanismOf<T>& m, double L) {
  for (auto& joint : m.joints) joint.point_first *= L, joint.point_second *= L, joint.radius *= L;
  for (auto& constraint : m.constraints) {
    const auto is_length = [&](const auto& term) {
      using Of = typename GeneralisedSpeedTermOf<T>::Kind;
      return term.kind == Of::coordinate ? m.coordinates[term.index].kind == CoordinateKind::length
                                         : term.kind == Of::velocity || term.kind == Of::velocity_body;
    };
    const bool length = std::any_of(constraint.terms.begin(), constraint.terms.end(), is_length);
    for (auto& term : constraint.terms) {
      if (length && !is_length(term)) term.factor *= L;
      term.position *= L;
    }
  }
  for (auto& coupling : m.couplings) {
    for (auto& term : coupling.leader.terms)
      if (m.coordinates[term.coordinate].kind == CoordinateKind::length) term.ratio /= L;
    if (m.coordinates[coupling.follower].kind == CoordinateKind::length) coupling.ratio *= L, coupling.offset *= L;
  }
  if (m.tool) m.tool->position *= L;
  for (auto& rough : m.assembly)
    if (m.coordinates[rough.coordinate].kind == CoordinateKind::length) rough.value *= L;
}

template <class T>
ExperimentOf<T> in_units(const ExperimentOf<T>& from, const Units& by) {
  ExperimentOf<T> out = from;
  out.mechanism.gravity *= by.length / (by.time * by.time);
  scale_masses(out.mechanism, by);
  scale_forces(out.mechanism, by);
  scale_geometry(out.mechanism, by.length);
  scale(out.trajectory.from, out.mechanism, by.length);
  scale(out.trajectory.to, out.mechanism, by.length);
  scale(out.trajectory.path, out.mechanism, by.length);
  out.trajectory.about *= by.length;
  out.trajectory.duration *= by.time;
  return out;
}

}  // namespace

Experiment displaced(const Experiment& from, const Matrix3& R, const Vector3& d) {
  Experiment out = from;
  Mechanism& m = out.mechanism;
  m.gravity = R * m.gravity;
  for (NamedPoint& point : m.bodies[ground].points) point.position = R * point.position + d;
  const bool planar = m.space == SpaceKind::planar;
  for (Joint& joint : m.joints) displace_ground(joint, R, d);
  for (Disc& disc : m.discs) {
    if (disc.body != ground) continue;
    disc.position = R * disc.position + d;
    disc.axis = R * disc.axis;
    disc.inertia = R * disc.inertia * R.transpose();
  }
  for (Load& load : m.loads) {
    if (load.frame != Frame::world) continue;
    for (Vector3& force : load.force) force = R * force;
    for (Vector3& moment : load.moment) moment = planar ? moment : Vector3(R * moment);
  }
  for (Spring& spring : m.springs) {
    if (spring.first == ground) spring.point_first = R * spring.point_first + d;
    if (spring.second == ground) spring.point_second = R * spring.point_second + d;
  }
  for (ForceElement& element : m.force_elements) {
    if (element.first == ground) element.point_first = R * element.point_first + d;
    if (element.second == ground) element.point_second = R * element.point_second + d;
  }
  displace(out.trajectory.from, R, d);
  displace(out.trajectory.to, R, d);
  displace(out.trajectory.path, R, d);
  out.trajectory.about = R * out.trajectory.about + d;
  return out;
}

bool can_be_displaced(const Experiment& from) {
  const auto spherical_on_ground = [](const Joint& joint) {
    return joint.type == JointType::spherical && joint.first == ground;
  };
  // with fewer freedoms than directions only x, or x and y, are driven; with four or five only some of the rotations about
  // the world's axes
  const bool planar = from.mechanism.space == SpaceKind::planar;
  const std::size_t freedoms = from.mechanism.actuators.size(), directions = planar ? 2 : 3;
  const bool whole = freedoms >= directions && (planar || (freedoms != 4 && freedoms != 5));
  const bool free = from.trajectory.drive == DriveKind::joints || whole;
  return free && from.trajectory.components.empty() &&
         std::none_of(from.mechanism.joints.begin(), from.mechanism.joints.end(), spherical_on_ground);
}

Experiment scaled(const Experiment& from, const Units& by) { return in_units(from, by); }

ExperimentOf<Expression> scaled(const ExperimentOf<Expression>& from, const Units& by) { return in_units(from, by); }

}  // namespace laws
