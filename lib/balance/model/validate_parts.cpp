// The faults of what a mechanism consists of, element by element.

#include "balance/model/fault_list.hpp"

#include "balance/base/extrema.hpp"

#include <algorithm>
#include <set>

namespace balance {

namespace {

bool is_planar(const Mechanism& mechanism) { return mechanism.space == SpaceKind::planar; }

void check_points(const Body& body, bool planar, ElementValidator& faults) {
  std::set<std::string> names;
  for (const NamedPoint& point : body.points) {
    if (!names.insert(point.name).second)
      faults.add(ValidationIssueKind::duplicate_name, "two of its points are called '" + point.name + "'");
    faults.check_position(point.position, planar, ("point '" + point.name + "'").c_str());
  }
}

/// There are joints of this type in the plane, or in space.
bool exists_in(JointType type, bool planar) {
  switch (type) {
    case JointType::revolute:
    case JointType::prismatic:
    case JointType::fixed: return true;
    case JointType::pin_slot: return planar;
    case JointType::cylindrical:
    case JointType::universal:
    case JointType::spherical:
    case JointType::planar:
    case JointType::rolling_disc:
    case JointType::rolling_sphere: return !planar;
  }
  return false;
}

void check_axes(const Joint& joint, bool planar, ElementValidator& faults) {
  constexpr double perpendicularity_tolerance = 1e-9;
  const bool slides = joint.type == JointType::prismatic || joint.type == JointType::pin_slot;
  if (joint.type == JointType::fixed || joint.type == JointType::spherical) return;
  faults.check_unit_vector(joint.axis, "its axis");
  if (planar && slides && joint.axis.z() != 0)
    faults.add(ValidationIssueKind::out_of_plane, "its axis must lie in the plane of the mechanism");
  if (planar && !slides && joint.axis != Vector3::UnitZ())
    faults.add(ValidationIssueKind::out_of_plane, "the axis of a planar revolute joint must be z");
  if (joint.type != JointType::universal && joint.type != JointType::planar && !is_rolling(joint.type)) return;
  faults.check_unit_vector(joint.axis2, "its axis2");
  if (std::abs(joint.axis.dot(joint.axis2)) > perpendicularity_tolerance)
    faults.add(ValidationIssueKind::axes_not_perpendicular,
               "its axes must be at a right angle, their cosine is " + format_element(joint.axis.dot(joint.axis2)));
}

void check_rotation(const Matrix3& R, bool planar, ElementValidator& faults) {
  constexpr double orthogonality_tolerance = 1e-9;
  if (!faults.check_finite(R, "its rotation")) return;
  if (!(max_abs(R * R.transpose() - Matrix3::Identity()) <= orthogonality_tolerance))
    faults.add(ValidationIssueKind::rotation_not_proper, "its rotation must be an orthogonal matrix");
  else if (R.determinant() < 0)
    faults.add(ValidationIssueKind::rotation_not_proper, "its rotation must not be a reflection");
  else if (planar && !(max_abs(R.col(2) - Vector3::UnitZ()) <= orthogonality_tolerance))
    faults.add(ValidationIssueKind::out_of_plane, "its rotation must be about z, as the mechanism is planar");
}

std::string format_mass_issue(double mass) { return "the mass must be positive, is " + format_element(mass); }

}  // namespace

bool check_followed(const CoordinateCombination& followed, std::size_t coordinates, const char* what,
                    ElementValidator& faults) {
  bool good = !followed.terms.empty();
  if (!good) faults.add(ValidationIssueKind::index_out_of_range, std::string(what) + " is missing");
  std::set<int> seen;
  for (const CoordinateTerm& term : followed.terms) {
    good = faults.check_index(term.coordinate, coordinates, what) && good;
    if (!seen.insert(term.coordinate).second)
      faults.add(ValidationIssueKind::duplicate_reference, std::string(what) + " is named twice");
    if (faults.check_finite(term.ratio, "the ratio") && term.ratio == 0)
      faults.add(ValidationIssueKind::ratio_zero, "no ratio must be zero: what does not count is not followed");
  }
  return good;
}

void check_bodies(const Mechanism& mechanism, std::vector<ValidationIssue>& all) {
  const bool planar = is_planar(mechanism);
  std::set<std::string> names;
  for (std::size_t b = 0; b < mechanism.bodies.size(); ++b) {
    const Body& body = mechanism.bodies[b];
    ElementValidator faults(ElementKind::body, b, body.name, all);
    if (!names.insert(body.name).second)
      faults.add(ValidationIssueKind::duplicate_name, "another body has the same name");
    check_points(body, planar, faults);
    if (b == static_cast<std::size_t>(ground)) {
      if (body.mass != 0 || !body.inertia.isZero(0))
        faults.add(ValidationIssueKind::ground_with_mass,
                   "the first body is the ground, its mass and inertia must be zero");
      continue;
    }
    const bool finite = faults.check_finite(body.mass, "the mass");
    faults.check_position(body.com, planar, "the centre of mass");
    if (body.inertia_as_given) {
      faults.check_finite(body.inertia, "the inertia");
      if (finite && body.mass < 0) faults.add(ValidationIssueKind::mass_not_positive, format_mass_issue(body.mass));
      continue;
    }
    if (finite && !is_valid_mass(body.mass, body.inertia))
      faults.add(ValidationIssueKind::mass_not_positive, format_mass_issue(body.mass));
    check_inertia(body.inertia, planar, InertiaOwner::body, faults);
  }
}

void check_joints(const Mechanism& mechanism, std::vector<ValidationIssue>& all) {
  const bool planar = is_planar(mechanism);
  std::set<std::string> names;
  for (std::size_t j = 0; j < mechanism.joints.size(); ++j) {
    const Joint& joint = mechanism.joints[j];
    ElementValidator faults(ElementKind::joint, j, joint.name, all);
    if (!names.insert(joint.name).second)
      faults.add(ValidationIssueKind::duplicate_name, "another joint has the same name");
    const bool first = faults.check_index(joint.first, mechanism.bodies.size(), "its first body");
    const bool second = faults.check_index(joint.second, mechanism.bodies.size(), "its second body");
    if (first && second && joint.first == joint.second)
      faults.add(ValidationIssueKind::same_body, "it must connect two bodies, not one with itself");
    faults.check_position(joint.point_first, planar, "its point on the first body");
    faults.check_position(joint.point_second, planar, "its point on the second body");
    if (!exists_in(joint.type, planar))
      faults.add(ValidationIssueKind::joint_type_not_in_space,
                 std::string("there are no joints of this type ") + (planar ? "in the plane" : "in space"));
    else
      check_axes(joint, planar, faults);
    check_rotation(joint.rotation, planar, faults);
    if (is_rolling(joint.type) && faults.check_finite(joint.radius, "the radius") && !(joint.radius > 0))
      faults.add(ValidationIssueKind::negative_number,
                 "the radius of what rolls must be positive, is " + format_element(joint.radius));
  }
}

void check_attachments(const Mechanism& mechanism, std::vector<ValidationIssue>& all) {
  const bool planar = is_planar(mechanism);
  std::set<std::pair<AttachmentKind, std::string>> names;
  for (std::size_t a = 0; a < mechanism.attachments.size(); ++a) {
    const Attachment& extra = mechanism.attachments[a];
    ElementValidator faults(ElementKind::attachment, a, extra.name, all);
    if (!extra.name.empty() && !names.emplace(extra.kind, extra.name).second)
      faults.add(ValidationIssueKind::duplicate_name, "another attachment has the same name");
    faults.check_index(extra.body, mechanism.bodies.size(), "its body");
    faults.check_position(extra.position, planar, "its position");
    if (faults.check_finite(extra.mass, "the mass") && extra.mass < 0)
      faults.add(ValidationIssueKind::mass_negative, "the mass must not be negative, is " + format_element(extra.mass));
    check_inertia(extra.inertia, planar, InertiaOwner::attachment, faults);
    if (!(extra.from < extra.until))
      faults.add(ValidationIssueKind::empty_payload_interval, "it is taken up at " + format_element(extra.from) +
                                                                  " s and set down at " + format_element(extra.until) +
                                                                  " s, which must be later");
  }
}

void check_discs(const Mechanism& mechanism, std::vector<ValidationIssue>& all) {
  const bool planar = is_planar(mechanism);
  std::set<std::string> names;
  for (std::size_t d = 0; d < mechanism.discs.size(); ++d) {
    const Disc& disc = mechanism.discs[d];
    ElementValidator faults(ElementKind::disc, d, disc.name, all);
    if (!disc.name.empty() && !names.insert(disc.name).second)
      faults.add(ValidationIssueKind::duplicate_name, "another disc has the same name");
    faults.check_index(disc.body, mechanism.bodies.size(), "its body");
    check_followed(disc.follows, mechanism.coordinates.size(), "the coordinate that it follows", faults);
    faults.check_position(disc.position, planar, "its position");
    faults.check_unit_vector(disc.axis, "its axis");
    if (planar && disc.axis != Vector3::UnitZ())
      faults.add(ValidationIssueKind::out_of_plane, "its axis must be z, as the mechanism is planar");
    if (faults.check_finite(disc.ratio, "the ratio") && disc.ratio == 0)
      faults.add(ValidationIssueKind::ratio_zero,
                 "the ratio must not be zero: a disc that does not turn is an attachment");
    if (faults.check_finite(disc.mass, "the mass") && disc.mass < 0)
      faults.add(ValidationIssueKind::mass_negative, "the mass must not be negative, is " + format_element(disc.mass));
    check_inertia(disc.inertia, planar, InertiaOwner::attachment, faults);
  }
}

namespace {

void check_table(const Load& load, bool planar, ElementValidator& faults) {
  const std::size_t entries = load.time.empty() ? 1 : load.time.size();
  if (load.force.size() != entries || load.moment.size() != entries)
    faults.add(ValidationIssueKind::load_table, "it must have " + std::to_string(entries) +
                                                    " forces and moments, has " + std::to_string(load.force.size()) +
                                                    " and " + std::to_string(load.moment.size()));
  for (const double time : load.time)
    if (!faults.check_finite(time, "a time")) return;
  for (std::size_t k = 1; k < load.time.size(); ++k)
    if (!(load.time[k] > load.time[k - 1]))
      return faults.add(ValidationIssueKind::load_table, "its times must increase, " + format_element(load.time[k]) +
                                                             " follows " + format_element(load.time[k - 1]));
  for (const Vector3& force : load.force) faults.check_position(force, planar, "a force");
  for (const Vector3& moment : load.moment)
    if (faults.check_finite(moment, "a moment") && planar && !moment.head<2>().isZero(0))
      faults.add(ValidationIssueKind::out_of_plane, "a moment of a planar mechanism must lie along z");
}

}  // namespace

void check_loads(const Mechanism& mechanism, std::vector<ValidationIssue>& all) {
  const bool planar = is_planar(mechanism);
  std::set<std::string> names;
  for (std::size_t k = 0; k < mechanism.loads.size(); ++k) {
    const Load& load = mechanism.loads[k];
    ElementValidator faults(ElementKind::load, k, load.name, all);
    if (!load.name.empty() && !names.insert(load.name).second)
      faults.add(ValidationIssueKind::duplicate_name, "another load has the same name");
    faults.check_index(load.body, mechanism.bodies.size(), "its body");
    faults.check_position(load.point, planar, "its point");
    if (load.frame != Frame::world && load.frame != Frame::body)
      faults.add(ValidationIssueKind::unknown_value, "its frame must be the world's or the body's");
    check_table(load, planar, faults);
  }
}

void check_springs(const Mechanism& mechanism, std::vector<ValidationIssue>& all) {
  const bool planar = is_planar(mechanism);
  std::set<std::string> names;
  for (std::size_t k = 0; k < mechanism.springs.size(); ++k) {
    const Spring& spring = mechanism.springs[k];
    ElementValidator faults(ElementKind::spring, k, spring.name, all);
    if (!spring.name.empty() && !names.insert(spring.name).second)
      faults.add(ValidationIssueKind::duplicate_name, "another spring has the same name");
    faults.check_not_negative(spring.stiffness, "the stiffness");
    if (spring.is_joint_spring()) {
      faults.check_index(spring.coordinate, mechanism.coordinates.size(), "its coordinate");
      faults.check_finite(spring.preload, "the preload");
      continue;
    }
    const bool first = faults.check_index(spring.first, mechanism.bodies.size(), "its first body");
    const bool second = faults.check_index(spring.second, mechanism.bodies.size(), "its second body");
    if (first && second && spring.first == spring.second)
      faults.add(ValidationIssueKind::same_body, "it must act between two bodies, not within one");
    faults.check_position(spring.point_first, planar, "its point on the first body");
    faults.check_position(spring.point_second, planar, "its point on the second body");
    faults.check_not_negative(spring.free_length, "the free length");
  }
}

void check_friction(const Mechanism& mechanism, std::vector<ValidationIssue>& all) {
  std::set<int> rubbed;
  for (std::size_t k = 0; k < mechanism.friction.size(); ++k) {
    const Friction& friction = mechanism.friction[k];
    ElementValidator faults(ElementKind::friction, k, "", all);
    if (faults.check_index(friction.coordinate, mechanism.coordinates.size(), "its coordinate") &&
        !rubbed.insert(friction.coordinate).second)
      faults.add(ValidationIssueKind::duplicate_reference, "its coordinate has friction already");
    faults.check_not_negative(friction.viscous, "the viscous part");
    faults.check_not_negative(friction.coulomb, "the dry part");
    if (friction.coulomb_backward) faults.check_not_negative(*friction.coulomb_backward, "the dry part backwards");
    bool finite = true;
    for (const std::optional<double>& limit : {friction.breakaway, friction.at_rest_backward})
      if (limit) finite = faults.check_finite(*limit, "the part at rest") && finite;
    if (finite &&
        (friction.static_limit(1) < friction.dry_friction(1) || friction.static_limit(-1) < friction.dry_friction(-1)))
      faults.add(ValidationIssueKind::breakaway_below_coulomb,
                 "the part at rest must not be less than that of sliding");
  }
}

}  // namespace balance
