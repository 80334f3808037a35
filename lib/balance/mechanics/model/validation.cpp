// The faults of what a mechanism consists of, element by element.

#include "balance/mechanics/model/validation.hpp"

#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/foundation/numerics/extrema.hpp"
#include "balance/mechanics/model/couplings.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <set>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace balance {

// Collects the faults of a mechanism while it is looked through.

/// "body 'crank'", or "body 2" where it has no name.
std::string format_element(ElementKind element, std::size_t index, std::string_view name);

/// Short, and long enough to tell 1 from 1.0000001.
std::string format_element(double number);

/// One element's faults.
class ElementValidator {
 public:
  ElementValidator(ElementKind element, std::size_t index, std::string_view name, std::vector<ValidationIssue>& all)
      : element_(element), index_(static_cast<int>(index)), who_(format_element(element, index, name)), all_(all) {}

  void add(ValidationIssueKind kind, const std::string& what) {
    all_.push_back({kind, element_, index_, who_ + ": " + what});
  }

  /// @return whether it is finite
  bool check_finite(double number, const char* what) {
    if (!std::isfinite(number))
      add(ValidationIssueKind::not_finite, std::string(what) + " must be finite, is " + format_element(number));
    return std::isfinite(number);
  }
  template <class Derived>
  bool check_finite(const Eigen::MatrixBase<Derived>& numbers, const char* what) {
    const bool good = numbers.allFinite();
    if (!good) add(ValidationIssueKind::not_finite, std::string(what) + " must consist of finite numbers");
    return good;
  }

  void check_not_negative(double number, const char* what) {
    if (check_finite(number, what) && number < 0)
      add(ValidationIssueKind::negative_number,
          std::string(what) + " must not be negative, is " + format_element(number));
  }

  /// @return whether `index` is one of `count`
  bool check_index(int index, std::size_t count, const char* what) {
    const bool good = index >= 0 && static_cast<std::size_t>(index) < count;
    if (!good)
      add(ValidationIssueKind::index_out_of_range,
          std::string(what) + " must be one of " + std::to_string(count) + " (from 0), is " + std::to_string(index));
    return good;
  }

  void check_unit_vector(const Vector3& axis, const char* what);
  /// A place in the plane of a planar mechanism.
  void check_position(const Vector3& position, bool planar, const char* what);

 private:
  ElementKind element_;
  int index_;
  std::string who_;
  std::vector<ValidationIssue>& all_;
};

void check_inertia(const Matrix3& inertia, bool planar, InertiaOwner bearer, ElementValidator& faults);

/// @param what "the coordinate that leads" @return whether all that is followed are coordinates
bool check_followed(const CoordinateCombination& followed, std::size_t coordinates, const char* what,
                    ElementValidator& faults);

// The parts of validate().
void check_bodies(const Mechanism& mechanism, std::vector<ValidationIssue>& all);
void check_joints(const Mechanism& mechanism, std::vector<ValidationIssue>& all);
void check_constraints(const Mechanism& mechanism, std::vector<ValidationIssue>& all);
void check_attachments(const Mechanism& mechanism, std::vector<ValidationIssue>& all);
void check_discs(const Mechanism& mechanism, std::vector<ValidationIssue>& all);
void check_loads(const Mechanism& mechanism, std::vector<ValidationIssue>& all);
void check_springs(const Mechanism& mechanism, std::vector<ValidationIssue>& all);
void check_friction(const Mechanism& mechanism, std::vector<ValidationIssue>& all);

namespace {

constexpr double inertia_tolerance = 1e-6;  ///< of the largest principal moment: values typed with six digits pass

}  // namespace

InertiaCheck find_inertia_issue(const Matrix3& inertia, bool planar, InertiaOwner bearer) {
  InertiaCheck verdict;
  const bool body = bearer == InertiaOwner::body;
  if (body && inertia.isZero(0)) return verdict;
  if (planar) {
    const double j = verdict.principal_moments[2] = inertia(2, 2);
    if (body ? !(j > 0) : j < 0) verdict.issue = InertiaIssue::not_positive_definite;
    return verdict;
  }
  const Eigen::SelfAdjointEigenSolver<Matrix3> solver(inertia, Eigen::EigenvaluesOnly);
  const Vector3& principal = verdict.principal_moments = solver.eigenvalues();  // increasing
  const double slack = inertia_tolerance * max_abs(principal);
  if (body ? !(principal[0] > 0) : principal[0] < -slack)
    verdict.issue = InertiaIssue::not_positive_definite;
  else if (principal[0] + principal[1] < principal[2] - slack)
    verdict.issue = InertiaIssue::triangle_violated;
  return verdict;
}

namespace {

constexpr double unit_vector_tolerance = 1e-9;       // directions typed with ten digits pass
constexpr double inertia_symmetry_tolerance = 1e-6;  // and inertias typed with six

const char* name_of(ElementKind element) {
  switch (element) {
    case ElementKind::mechanism: return "mechanism";
    case ElementKind::body: return "body";
    case ElementKind::joint: return "joint";
    case ElementKind::coordinate: return "coordinate";
    case ElementKind::coupling: return "coupling";
    case ElementKind::constraint: return "constraint";
    case ElementKind::attachment: return "attachment";
    case ElementKind::disc: return "disc";
    case ElementKind::load: return "load";
    case ElementKind::spring: return "spring";
    case ElementKind::friction: return "friction";
    case ElementKind::actuator: return "actuator";
    case ElementKind::tool: return "tool";
    case ElementKind::assembly: return "assembly";
  }
  return "";
}

}  // namespace

std::string format_element(ElementKind element, std::size_t index, std::string_view name) {
  const std::string kind = name_of(element);
  if (!name.empty()) return kind + " '" + std::string(name) + "'";
  return element == ElementKind::mechanism || element == ElementKind::tool ? kind : kind + " " + std::to_string(index);
}

std::string format_element(double number) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.9g", number);
  return text.data();
}

void ElementValidator::check_unit_vector(const Vector3& axis, const char* what) {
  if (!check_finite(axis, what)) return;
  const double length = axis.norm();
  if (!(std::abs(length - 1) <= unit_vector_tolerance))
    add(ValidationIssueKind::axis_not_unit,
        std::string(what) + " must be a unit vector, its length is " + format_element(length));
}

void ElementValidator::check_position(const Vector3& position, bool planar, const char* what) {
  if (check_finite(position, what) && planar && position.z() != 0)
    add(ValidationIssueKind::out_of_plane,
        std::string(what) + " of a planar mechanism must have z = 0, has " + format_element(position.z()));
}

void check_inertia(const Matrix3& inertia, bool planar, InertiaOwner bearer, ElementValidator& faults) {
  if (!faults.check_finite(inertia, "the inertia")) return;
  const double size = max_abs(inertia);
  Matrix3 rest = inertia;
  rest(2, 2) = 0;
  if (planar && !rest.isZero(0))
    faults.add(ValidationIssueKind::out_of_plane, "the inertia of a planar mechanism must have its zz entry alone");
  else if (!(max_abs((inertia - inertia.transpose()) / 2) <= inertia_symmetry_tolerance * size))
    return faults.add(ValidationIssueKind::inertia_not_symmetric, "the inertia must be a symmetric matrix");
  const InertiaCheck verdict = find_inertia_issue(inertia, planar, bearer);
  const Vector3& principal = verdict.principal_moments;
  const std::string found = planar ? ", is " + format_element(principal[2])
                                   : "; its principal moments are " + format_element(principal[0]) + ", " +
                                         format_element(principal[1]) + ", " + format_element(principal[2]);
  const char* positive = !planar                        ? "the inertia must be positive definite"
                         : bearer == InertiaOwner::body ? "the inertia must be positive"
                                                        : "the inertia must not be negative";
  if (verdict.issue == InertiaIssue::not_positive_definite)
    faults.add(ValidationIssueKind::inertia_not_positive, positive + found);
  if (verdict.issue == InertiaIssue::triangle_violated)
    faults.add(ValidationIssueKind::inertia_triangle_violated,
               "no principal moment of inertia can be above the sum of the other two" + found);
}

namespace {

/// @return false if nothing else can be said
bool check_counts(const Mechanism& mechanism, std::vector<ValidationIssue>& all) {
  ElementValidator faults(ElementKind::mechanism, 0, mechanism.name, all);
  if (mechanism.space != SpaceKind::planar && mechanism.space != SpaceKind::spatial) {
    faults.add(ValidationIssueKind::unknown_value, "its space must be planar or spatial");
    return false;
  }
  if (mechanism.bodies.empty())
    faults.add(ValidationIssueKind::no_ground, "it has no bodies; the first one is the ground");
  else if (mechanism.bodies.size() == 1)
    faults.add(ValidationIssueKind::no_moving_body, "it has no moving body");
  faults.check_position(mechanism.gravity, mechanism.space == SpaceKind::planar, "gravity");
  return true;
}

void check_coordinates(const Mechanism& mechanism, std::vector<ValidationIssue>& all) {
  ElementValidator faults(ElementKind::mechanism, 0, mechanism.name, all);
  const std::vector<Coordinate> expected = list_coordinates(mechanism.space, mechanism.joints);
  const bool same =
      std::equal(expected.begin(), expected.end(), mechanism.coordinates.begin(), mechanism.coordinates.end(),
                 [](const Coordinate& a, const Coordinate& b) {
                   return a.name == b.name && a.joint == b.joint && a.index == b.index && a.kind == b.kind;
                 });
  if (!same)
    faults.add(ValidationIssueKind::coordinates_inconsistent,
               "its coordinates must be list_coordinates(space, joints): " + std::to_string(expected.size()) +
                   " of them; it has " + std::to_string(mechanism.coordinates.size()));
}

/// Every body is reached from the ground.
void check_connected(const Mechanism& mechanism, std::vector<ValidationIssue>& all) {
  std::vector<bool> reached(mechanism.bodies.size(), false);
  const auto at = [](BodyId body) { return static_cast<std::size_t>(body); };
  const auto exists = [&](BodyId body) { return body >= 0 && at(body) < mechanism.bodies.size(); };
  if (!reached.empty()) reached[ground] = true;
  for (bool growing = true; growing;) {
    growing = false;
    for (const Joint& joint : mechanism.joints) {
      if (!exists(joint.first) || !exists(joint.second) || reached[at(joint.first)] == reached[at(joint.second)])
        continue;
      reached[at(joint.first)] = reached[at(joint.second)] = true;
      growing = true;
    }
  }
  for (std::size_t b = 1; b < mechanism.bodies.size(); ++b)
    if (!reached[b])
      ElementValidator(ElementKind::body, b, mechanism.bodies[b].name, all)
          .add(ValidationIssueKind::not_connected, "no chain of joints leads from the ground to it");
}

void check_couplings(const Mechanism& mechanism, std::vector<ValidationIssue>& all) {
  const std::size_t coordinates = mechanism.coordinates.size();
  CouplingGraph leaders(coordinates);
  for (std::size_t k = 0; k < mechanism.couplings.size(); ++k) {
    const Coupling& coupling = mechanism.couplings[k];
    ElementValidator faults(ElementKind::coupling, k, "", all);
    const bool follower = faults.check_index(coupling.follower, coordinates, "the coordinate that follows");
    const bool leader = check_followed(coupling.leader, coordinates, "the coordinate that leads", faults);
    faults.check_finite(coupling.offset, "the offset");
    if (faults.check_finite(coupling.ratio, "the ratio") && coupling.ratio == 0)
      faults.add(ValidationIssueKind::ratio_zero, "the ratio must not be zero: a joint that does not move is fixed");
    if (!follower || !leader) continue;
    const std::string name = mechanism.coordinates[static_cast<std::size_t>(coupling.follower)].name;
    std::vector<CoordinateId>& led_by = leaders[static_cast<std::size_t>(coupling.follower)];
    if (!led_by.empty())
      faults.add(ValidationIssueKind::duplicate_follower, "'" + name + "' follows another coordinate already");
    else if (creates_coupling_cycle(leaders, coupling.follower, coordinates_of(coupling.leader)))
      faults.add(ValidationIssueKind::coupling_cycle, "'" + name + "' follows itself in a circle");
    else
      led_by = coordinates_of(coupling.leader);
  }
}

void check_references(const Mechanism& mechanism, std::vector<ValidationIssue>& all) {
  std::set<CoordinateId> actuated;
  for (std::size_t a = 0; a < mechanism.actuators.size(); ++a) {
    ElementValidator faults(ElementKind::actuator, a, "", all);
    if (faults.check_index(mechanism.actuators[a], mechanism.coordinates.size(), "its coordinate") &&
        !actuated.insert(mechanism.actuators[a]).second)
      faults.add(ValidationIssueKind::duplicate_reference, "another actuator drives the same coordinate");
  }
  if (mechanism.tool) {
    ElementValidator faults(ElementKind::tool, 0, "", all);
    faults.check_index(mechanism.tool->body, mechanism.bodies.size(), "its body");
    faults.check_position(mechanism.tool->position, mechanism.space == SpaceKind::planar, "its position");
  }
  for (std::size_t k = 0; k < mechanism.assembly.size(); ++k) {
    ElementValidator faults(ElementKind::assembly, k, "", all);
    faults.check_index(mechanism.assembly[k].coordinate, mechanism.coordinates.size(), "its coordinate");
    faults.check_finite(mechanism.assembly[k].value, "the value");
  }
}

}  // namespace

std::vector<ValidationIssue> validate(const Mechanism& mechanism) {
  std::vector<ValidationIssue> all;
  if (!check_counts(mechanism, all)) return all;
  check_bodies(mechanism, all);
  check_joints(mechanism, all);
  check_coordinates(mechanism, all);
  check_connected(mechanism, all);
  check_couplings(mechanism, all);
  check_constraints(mechanism, all);
  check_attachments(mechanism, all);
  check_discs(mechanism, all);
  check_loads(mechanism, all);
  check_springs(mechanism, all);
  check_friction(mechanism, all);
  check_references(mechanism, all);
  return all;
}

bool has_mass(const Mechanism& mechanism) {
  const auto heavy = [](const auto& part) { return part.mass > 0; };
  return std::any_of(mechanism.bodies.begin(), mechanism.bodies.end(), heavy) ||
         std::any_of(mechanism.attachments.begin(), mechanism.attachments.end(), heavy) ||
         std::any_of(mechanism.discs.begin(), mechanism.discs.end(), heavy);
}

void require_valid(const Mechanism& mechanism) {
  std::string sentences;
  for (const ValidationIssue& fault : validate(mechanism)) sentences += (sentences.empty() ? "" : "\n") + fault.message;
  if (!sentences.empty()) throw std::invalid_argument(sentences);
}

// The faults of constraints on speeds.
void check_constraints(const Mechanism& mechanism, std::vector<ValidationIssue>& all) {
  const bool planar = mechanism.space == SpaceKind::planar;
  std::set<std::string> names;
  for (std::size_t k = 0; k < mechanism.constraints.size(); ++k) {
    const GeneralisedSpeed& constraint = mechanism.constraints[k];
    ElementValidator faults(ElementKind::constraint, k, constraint.name, all);
    if (!constraint.name.empty() && !names.insert(constraint.name).second)
      faults.add(ValidationIssueKind::duplicate_name, "another constraint has the same name");
    if (constraint.terms.empty()) faults.add(ValidationIssueKind::index_out_of_range, "what must be zero is missing");
    for (const GeneralisedSpeedTerm& term : constraint.terms) {
      using enum GeneralisedSpeedTerm::Kind;
      if (faults.check_finite(term.factor, "a factor") && term.factor == 0)
        faults.add(ValidationIssueKind::ratio_zero, "no factor must be zero: what does not count is left out");
      if (term.kind == coordinate) {
        faults.check_index(term.index, mechanism.coordinates.size(), "a coordinate");
        continue;
      }
      faults.check_index(term.body, mechanism.bodies.size(), "a body");
      faults.check_position(term.position, planar, "a point");
      const bool turns = term.kind == angular_velocity || term.kind == angular_velocity_body;
      if (faults.check_index(term.index, 3, "a component") && planar && (term.index == 2) != turns)
        faults.add(ValidationIssueKind::out_of_plane,
                   "in the plane points move along x and y, and bodies turn about z");
    }
  }
}

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
