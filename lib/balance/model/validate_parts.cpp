// The faults of what a mechanism consists of, element by element.

#include "balance/model/fault_list.hpp"

#include "balance/base/extrema.hpp"

#include <algorithm>
#include <set>

namespace balance {

namespace {

bool is_planar(const Mechanism& mechanism) { return mechanism.space == SpaceKind::planar; }

void check_points(const Body& body, bool planar, ElementFaults& faults) {
  std::set<std::string> names;
  for (const NamedPoint& point : body.points) {
    if (!names.insert(point.name).second)
      faults.add(FaultKind::duplicate_name, "two of its points are called '" + point.name + "'");
    faults.place(point.position, planar, ("point '" + point.name + "'").c_str());
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

void check_axes(const Joint& joint, bool planar, ElementFaults& faults) {
  constexpr double square = 1e-9;
  const bool slides = joint.type == JointType::prismatic || joint.type == JointType::pin_slot;
  if (joint.type == JointType::fixed || joint.type == JointType::spherical) return;
  faults.unit(joint.axis, "its axis");
  if (planar && slides && joint.axis.z() != 0)
    faults.add(FaultKind::out_of_plane, "its axis must lie in the plane of the mechanism");
  if (planar && !slides && joint.axis != Vector3::UnitZ())
    faults.add(FaultKind::out_of_plane, "the axis of a planar revolute joint must be z");
  if (joint.type != JointType::universal && joint.type != JointType::planar && !rolls(joint.type)) return;
  faults.unit(joint.axis2, "its axis2");
  if (std::abs(joint.axis.dot(joint.axis2)) > square)
    faults.add(FaultKind::axes_not_square,
               "its axes must be at a right angle, their cosine is " + text_of(joint.axis.dot(joint.axis2)));
}

void check_rotation(const Matrix3& R, bool planar, ElementFaults& faults) {
  constexpr double error = 1e-9;
  if (!faults.finite(R, "its rotation")) return;
  if (!(max_abs(R * R.transpose() - Matrix3::Identity()) <= error))
    faults.add(FaultKind::rotation_not_proper, "its rotation must be an orthogonal matrix");
  else if (R.determinant() < 0)
    faults.add(FaultKind::rotation_not_proper, "its rotation must not be a reflection");
  else if (planar && !(max_abs(R.col(2) - Vector3::UnitZ()) <= error))
    faults.add(FaultKind::out_of_plane, "its rotation must be about z, as the mechanism is planar");
}

std::string mass_sentence(double mass) { return "the mass must be positive, is " + text_of(mass); }

}  // namespace

bool check_followed(const Followed& followed, std::size_t coordinates, const char* what, ElementFaults& faults) {
  bool good = !followed.terms.empty();
  if (!good) faults.add(FaultKind::index_out_of_range, std::string(what) + " is missing");
  std::set<int> seen;
  for (const CoordinateTerm& term : followed.terms) {
    good = faults.in_range(term.coordinate, coordinates, what) && good;
    if (!seen.insert(term.coordinate).second)
      faults.add(FaultKind::duplicate_reference, std::string(what) + " is named twice");
    if (faults.finite(term.ratio, "the ratio") && term.ratio == 0)
      faults.add(FaultKind::ratio_zero, "no ratio must be zero: what does not count is not followed");
  }
  return good;
}

void check_bodies(const Mechanism& mechanism, std::vector<Fault>& all) {
  const bool planar = is_planar(mechanism);
  std::set<std::string> names;
  for (std::size_t b = 0; b < mechanism.bodies.size(); ++b) {
    const Body& body = mechanism.bodies[b];
    ElementFaults faults(ElementKind::body, b, body.name, all);
    if (!names.insert(body.name).second) faults.add(FaultKind::duplicate_name, "another body has the same name");
    check_points(body, planar, faults);
    if (b == static_cast<std::size_t>(ground)) {
      if (body.mass != 0 || !body.inertia.isZero(0))
        faults.add(FaultKind::ground_with_mass, "the first body is the ground, its mass and inertia must be zero");
      continue;
    }
    const bool finite = faults.finite(body.mass, "the mass");
    faults.place(body.com, planar, "the centre of mass");
    if (body.inertia_as_given) {
      faults.finite(body.inertia, "the inertia");
      if (finite && body.mass < 0) faults.add(FaultKind::mass_not_positive, mass_sentence(body.mass));
      continue;
    }
    if (finite && !can_weigh(body.mass, body.inertia))
      faults.add(FaultKind::mass_not_positive, mass_sentence(body.mass));
    check_inertia(body.inertia, planar, InertiaOf::body, faults);
  }
}

void check_joints(const Mechanism& mechanism, std::vector<Fault>& all) {
  const bool planar = is_planar(mechanism);
  std::set<std::string> names;
  for (std::size_t j = 0; j < mechanism.joints.size(); ++j) {
    const Joint& joint = mechanism.joints[j];
    ElementFaults faults(ElementKind::joint, j, joint.name, all);
    if (!names.insert(joint.name).second) faults.add(FaultKind::duplicate_name, "another joint has the same name");
    const bool first = faults.in_range(joint.first, mechanism.bodies.size(), "its first body");
    const bool second = faults.in_range(joint.second, mechanism.bodies.size(), "its second body");
    if (first && second && joint.first == joint.second)
      faults.add(FaultKind::same_body, "it must connect two bodies, not one with itself");
    faults.place(joint.point_first, planar, "its point on the first body");
    faults.place(joint.point_second, planar, "its point on the second body");
    if (!exists_in(joint.type, planar))
      faults.add(FaultKind::joint_type,
                 std::string("there are no joints of this type ") + (planar ? "in the plane" : "in space"));
    else
      check_axes(joint, planar, faults);
    check_rotation(joint.rotation, planar, faults);
    if (rolls(joint.type) && faults.finite(joint.radius, "the radius") && !(joint.radius > 0))
      faults.add(FaultKind::negative_number, "the radius of what rolls must be positive, is " + text_of(joint.radius));
  }
}

void check_attachments(const Mechanism& mechanism, std::vector<Fault>& all) {
  const bool planar = is_planar(mechanism);
  std::set<std::pair<AttachmentKind, std::string>> names;
  for (std::size_t a = 0; a < mechanism.attachments.size(); ++a) {
    const Attachment& extra = mechanism.attachments[a];
    ElementFaults faults(ElementKind::attachment, a, extra.name, all);
    if (!extra.name.empty() && !names.emplace(extra.kind, extra.name).second)
      faults.add(FaultKind::duplicate_name, "another attachment has the same name");
    faults.in_range(extra.body, mechanism.bodies.size(), "its body");
    faults.place(extra.position, planar, "its position");
    if (faults.finite(extra.mass, "the mass") && extra.mass < 0)
      faults.add(FaultKind::mass_negative, "the mass must not be negative, is " + text_of(extra.mass));
    check_inertia(extra.inertia, planar, InertiaOf::attachment, faults);
    if (!(extra.from < extra.until))
      faults.add(FaultKind::empty_stretch, "it is taken up at " + text_of(extra.from) + " s and set down at " +
                                               text_of(extra.until) + " s, which must be later");
  }
}

void check_discs(const Mechanism& mechanism, std::vector<Fault>& all) {
  const bool planar = is_planar(mechanism);
  std::set<std::string> names;
  for (std::size_t d = 0; d < mechanism.discs.size(); ++d) {
    const Disc& disc = mechanism.discs[d];
    ElementFaults faults(ElementKind::disc, d, disc.name, all);
    if (!disc.name.empty() && !names.insert(disc.name).second)
      faults.add(FaultKind::duplicate_name, "another disc has the same name");
    faults.in_range(disc.body, mechanism.bodies.size(), "its body");
    check_followed(disc.follows, mechanism.coordinates.size(), "the coordinate that it follows", faults);
    faults.place(disc.position, planar, "its position");
    faults.unit(disc.axis, "its axis");
    if (planar && disc.axis != Vector3::UnitZ())
      faults.add(FaultKind::out_of_plane, "its axis must be z, as the mechanism is planar");
    if (faults.finite(disc.ratio, "the ratio") && disc.ratio == 0)
      faults.add(FaultKind::ratio_zero, "the ratio must not be zero: a disc that does not turn is an attachment");
    if (faults.finite(disc.mass, "the mass") && disc.mass < 0)
      faults.add(FaultKind::mass_negative, "the mass must not be negative, is " + text_of(disc.mass));
    check_inertia(disc.inertia, planar, InertiaOf::attachment, faults);
  }
}

namespace {

void check_table(const Load& load, bool planar, ElementFaults& faults) {
  const std::size_t entries = load.time.empty() ? 1 : load.time.size();
  if (load.force.size() != entries || load.moment.size() != entries)
    faults.add(FaultKind::load_table, "it must have " + std::to_string(entries) + " forces and moments, has " +
                                          std::to_string(load.force.size()) + " and " +
                                          std::to_string(load.moment.size()));
  for (const double time : load.time)
    if (!faults.finite(time, "a time")) return;
  for (std::size_t k = 1; k < load.time.size(); ++k)
    if (!(load.time[k] > load.time[k - 1]))
      return faults.add(FaultKind::load_table,
                        "its times must increase, " + text_of(load.time[k]) + " follows " + text_of(load.time[k - 1]));
  for (const Vector3& force : load.force) faults.place(force, planar, "a force");
  for (const Vector3& moment : load.moment)
    if (faults.finite(moment, "a moment") && planar && !moment.head<2>().isZero(0))
      faults.add(FaultKind::out_of_plane, "a moment of a planar mechanism must lie along z");
}

}  // namespace

void check_loads(const Mechanism& mechanism, std::vector<Fault>& all) {
  const bool planar = is_planar(mechanism);
  std::set<std::string> names;
  for (std::size_t k = 0; k < mechanism.loads.size(); ++k) {
    const Load& load = mechanism.loads[k];
    ElementFaults faults(ElementKind::load, k, load.name, all);
    if (!load.name.empty() && !names.insert(load.name).second)
      faults.add(FaultKind::duplicate_name, "another load has the same name");
    faults.in_range(load.body, mechanism.bodies.size(), "its body");
    faults.place(load.point, planar, "its point");
    if (load.frame != Frame::world && load.frame != Frame::body)
      faults.add(FaultKind::unknown_value, "its frame must be the world's or the body's");
    check_table(load, planar, faults);
  }
}

void check_springs(const Mechanism& mechanism, std::vector<Fault>& all) {
  const bool planar = is_planar(mechanism);
  std::set<std::string> names;
  for (std::size_t k = 0; k < mechanism.springs.size(); ++k) {
    const Spring& spring = mechanism.springs[k];
    ElementFaults faults(ElementKind::spring, k, spring.name, all);
    if (!spring.name.empty() && !names.insert(spring.name).second)
      faults.add(FaultKind::duplicate_name, "another spring has the same name");
    faults.not_negative(spring.stiffness, "the stiffness");
    if (spring.in_joint()) {
      faults.in_range(spring.coordinate, mechanism.coordinates.size(), "its coordinate");
      faults.finite(spring.preload, "the preload");
      continue;
    }
    const bool first = faults.in_range(spring.first, mechanism.bodies.size(), "its first body");
    const bool second = faults.in_range(spring.second, mechanism.bodies.size(), "its second body");
    if (first && second && spring.first == spring.second)
      faults.add(FaultKind::same_body, "it must act between two bodies, not within one");
    faults.place(spring.point_first, planar, "its point on the first body");
    faults.place(spring.point_second, planar, "its point on the second body");
    faults.not_negative(spring.free_length, "the free length");
  }
}

void check_friction(const Mechanism& mechanism, std::vector<Fault>& all) {
  std::set<int> rubbed;
  for (std::size_t k = 0; k < mechanism.friction.size(); ++k) {
    const Friction& friction = mechanism.friction[k];
    ElementFaults faults(ElementKind::friction, k, "", all);
    if (faults.in_range(friction.coordinate, mechanism.coordinates.size(), "its coordinate") &&
        !rubbed.insert(friction.coordinate).second)
      faults.add(FaultKind::duplicate_reference, "its coordinate has friction already");
    faults.not_negative(friction.viscous, "the viscous part");
    faults.not_negative(friction.coulomb, "the dry part");
    if (friction.coulomb_backward) faults.not_negative(*friction.coulomb_backward, "the dry part backwards");
    bool finite = true;
    for (const std::optional<double>& limit : {friction.at_rest, friction.at_rest_backward})
      if (limit) finite = faults.finite(*limit, "the part at rest") && finite;
    if (finite && (friction.static_limit(1) < friction.dry(1) || friction.static_limit(-1) < friction.dry(-1)))
      faults.add(FaultKind::friction_at_rest, "the part at rest must not be less than that of sliding");
  }
}

}  // namespace balance
