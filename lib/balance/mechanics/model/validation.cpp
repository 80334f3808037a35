// Validation of a mechanism, element by element.

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

namespace balance::model {

// Collects the faults of a mechanism.

/// "body 'crank'", or "body 2" if it has no name.
std::string format_element(ElementKind element, std::size_t index, std::string_view name);

/// Short, but with enough digits to distinguish 1 from 1.0000001.
std::string format_element(double number);

/// Collects the faults of one element.
class ElementValidator {
 public:
  ElementValidator(ElementKind element, std::size_t index, std::string_view name, std::vector<ValidationIssue>& issues)
      : element_(element),
        index_(static_cast<int>(index)),
        label_(format_element(element, index, name)),
        issues_(issues) {}

  void add(ValidationIssueKind kind, const std::string& what) {
    issues_.push_back({kind, element_, index_, label_ + ": " + what});
  }

  /// @return whether it is finite
  bool check_finite(double number, const char* what) {
    if (!std::isfinite(number))
      add(ValidationIssueKind::not_finite, std::string(what) + " must be finite, is " + format_element(number));
    return std::isfinite(number);
  }
  template <class Derived>
  bool check_finite(const Eigen::MatrixBase<Derived>& numbers, const char* what) {
    const bool is_valid = numbers.allFinite();
    if (!is_valid) add(ValidationIssueKind::not_finite, std::string(what) + " must consist of finite numbers");
    return is_valid;
  }

  void check_not_negative(double number, const char* what) {
    if (check_finite(number, what) && number < 0)
      add(ValidationIssueKind::negative_number,
          std::string(what) + " must not be negative, is " + format_element(number));
  }

  /// @return whether `index` is one of `count`
  bool check_index(int index, std::size_t count, const char* what) {
    const bool is_valid = index >= 0 && static_cast<std::size_t>(index) < count;
    if (!is_valid)
      add(ValidationIssueKind::index_out_of_range,
          std::string(what) + " must be one of " + std::to_string(count) + " (from 0), is " + std::to_string(index));
    return is_valid;
  }

  void check_unit_vector(const Vector3& axis, const char* what);
  /// Checks that it is finite and, if planar, that z = 0.
  void check_position(const Vector3& position, bool planar, const char* what);

 private:
  ElementKind element_;
  int index_;
  std::string label_;
  std::vector<ValidationIssue>& issues_;
};

void check_inertia(const Matrix3& inertia, bool planar, InertiaOwner owner, ElementValidator& faults);

/// @param what "the coordinate that leads" @return whether there are terms and all followed coordinates exist
bool check_followed(const CoordinateCombination& followed, std::size_t coordinates, const char* what,
                    ElementValidator& faults);

// The parts of validate().
void check_bodies(const Mechanism& mechanism, std::vector<ValidationIssue>& issues);
void check_joints(const Mechanism& mechanism, std::vector<ValidationIssue>& issues);
void check_constraints(const Mechanism& mechanism, std::vector<ValidationIssue>& issues);
void check_attachments(const Mechanism& mechanism, std::vector<ValidationIssue>& issues);
void check_discs(const Mechanism& mechanism, std::vector<ValidationIssue>& issues);
void check_loads(const Mechanism& mechanism, std::vector<ValidationIssue>& issues);
void check_springs(const Mechanism& mechanism, std::vector<ValidationIssue>& issues);
void check_force_elements(const Mechanism& mechanism, std::vector<ValidationIssue>& issues);
void check_friction(const Mechanism& mechanism, std::vector<ValidationIssue>& issues);

namespace {

constexpr double inertia_tolerance = 1e-6;  ///< of the largest principal moment: admits values typed with six digits

}  // namespace

InertiaCheck find_inertia_issue(const Matrix3& inertia, bool planar, InertiaOwner owner) {
  InertiaCheck check;
  const bool body = owner == InertiaOwner::body;
  if (body && inertia.isZero(0)) return check;
  if (planar) {
    const double j = check.principal_moments[2] = inertia(2, 2);
    if (body ? !(j > 0) : j < 0) check.issue = InertiaIssue::not_positive_definite;
    return check;
  }
  const Eigen::SelfAdjointEigenSolver<Matrix3> solver(inertia, Eigen::EigenvaluesOnly);
  const Vector3& principal = check.principal_moments = solver.eigenvalues();  // increasing
  const double tolerance = inertia_tolerance * numerics::max_abs(principal);
  if (body ? !(principal[0] > 0) : principal[0] < -tolerance)
    check.issue = InertiaIssue::not_positive_definite;
  else if (principal[0] + principal[1] < principal[2] - tolerance)
    check.issue = InertiaIssue::triangle_violated;
  return check;
}

namespace {

constexpr double unit_vector_tolerance = 1e-9;       // admits directions typed with ten digits
constexpr double inertia_symmetry_tolerance = 1e-6;  // admits inertias typed with six digits

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
    case ElementKind::force_element: return "force element";
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

void check_inertia(const Matrix3& inertia, bool planar, InertiaOwner owner, ElementValidator& faults) {
  if (!faults.check_finite(inertia, "the inertia")) return;
  const double size = numerics::max_abs(inertia);
  Matrix3 off_plane = inertia;
  off_plane(2, 2) = 0;
  if (planar && !off_plane.isZero(0))
    faults.add(ValidationIssueKind::out_of_plane, "the inertia of a planar mechanism must have only a zz entry");
  else if (!(numerics::max_abs((inertia - inertia.transpose()) / 2) <= inertia_symmetry_tolerance * size))
    return faults.add(ValidationIssueKind::inertia_not_symmetric, "the inertia must be a symmetric matrix");
  const InertiaCheck check = find_inertia_issue(inertia, planar, owner);
  const Vector3& principal = check.principal_moments;
  const std::string actual_text = planar ? ", is " + format_element(principal[2])
                                         : "; its principal moments are " + format_element(principal[0]) + ", " +
                                               format_element(principal[1]) + ", " + format_element(principal[2]);
  const char* positive = !planar                       ? "the inertia must be positive definite"
                         : owner == InertiaOwner::body ? "the inertia must be positive"
                                                       : "the inertia must not be negative";
  if (check.issue == InertiaIssue::not_positive_definite)
    faults.add(ValidationIssueKind::inertia_not_positive, positive + actual_text);
  if (check.issue == InertiaIssue::triangle_violated)
    faults.add(ValidationIssueKind::inertia_triangle_violated,
               "no principal moment of inertia may exceed the sum of the other two" + actual_text);
}

namespace {

/// @return false if no further checks are possible
bool check_counts(const Mechanism& mechanism, std::vector<ValidationIssue>& issues) {
  ElementValidator faults(ElementKind::mechanism, 0, mechanism.name, issues);
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

void check_coordinates(const Mechanism& mechanism, std::vector<ValidationIssue>& issues) {
  ElementValidator faults(ElementKind::mechanism, 0, mechanism.name, issues);
  const std::vector<Coordinate> expected = list_coordinates(mechanism.space, mechanism.joints);
  const bool is_same =
      std::equal(expected.begin(), expected.end(), mechanism.coordinates.begin(), mechanism.coordinates.end(),
                 [](const Coordinate& a, const Coordinate& b) {
                   return a.name == b.name && a.joint == b.joint && a.index == b.index && a.kind == b.kind;
                 });
  if (!is_same)
    faults.add(ValidationIssueKind::coordinates_inconsistent,
               "its coordinates must be list_coordinates(space, joints): " + std::to_string(expected.size()) +
                   " of them; it has " + std::to_string(mechanism.coordinates.size()));
}

/// Checks that every body is connected to the ground.
void check_connected(const Mechanism& mechanism, std::vector<ValidationIssue>& issues) {
  std::vector<bool> is_reached(mechanism.bodies.size(), false);
  const auto index = [](BodyId body) { return static_cast<std::size_t>(body); };
  const auto exists = [&](BodyId body) { return body >= 0 && index(body) < mechanism.bodies.size(); };
  if (!is_reached.empty()) is_reached[ground] = true;
  for (bool has_grown = true; has_grown;) {
    has_grown = false;
    for (const Joint& joint : mechanism.joints) {
      if (!exists(joint.first) || !exists(joint.second) ||
          is_reached[index(joint.first)] == is_reached[index(joint.second)])
        continue;
      is_reached[index(joint.first)] = is_reached[index(joint.second)] = true;
      has_grown = true;
    }
  }
  for (std::size_t b = 1; b < mechanism.bodies.size(); ++b)
    if (!is_reached[b])
      ElementValidator(ElementKind::body, b, mechanism.bodies[b].name, issues)
          .add(ValidationIssueKind::not_connected, "no chain of joints connects it to the ground");
}

void check_couplings(const Mechanism& mechanism, std::vector<ValidationIssue>& issues) {
  const std::size_t coordinates = mechanism.coordinates.size();
  CouplingGraph leaders(coordinates);
  for (std::size_t k = 0; k < mechanism.couplings.size(); ++k) {
    const Coupling& coupling = mechanism.couplings[k];
    ElementValidator faults(ElementKind::coupling, k, "", issues);
    const bool follower = faults.check_index(coupling.follower, coordinates, "the coordinate that follows");
    const bool leader = check_followed(coupling.leader, coordinates, "the coordinate that leads", faults);
    faults.check_finite(coupling.offset, "the offset");
    if (faults.check_finite(coupling.ratio, "the ratio") && coupling.ratio == 0)
      faults.add(ValidationIssueKind::ratio_zero, "the ratio must not be zero: a joint that does not move is fixed");
    if (!follower || !leader) continue;
    const std::string name = mechanism.coordinates[static_cast<std::size_t>(coupling.follower)].name;
    std::vector<CoordinateId>& own_leaders = leaders[static_cast<std::size_t>(coupling.follower)];
    if (!own_leaders.empty())
      faults.add(ValidationIssueKind::duplicate_follower, "'" + name + "' already follows another coordinate");
    else if (creates_coupling_cycle(leaders, coupling.follower, coordinates_of(coupling.leader)))
      faults.add(ValidationIssueKind::coupling_cycle, "'" + name + "' follows itself in a cycle");
    else
      own_leaders = coordinates_of(coupling.leader);
  }
}

void check_torque_distribution(const Mechanism& mechanism, std::vector<ValidationIssue>& issues) {
  if (!mechanism.torque_distribution) return;
  const std::vector<EffortShare>& shares = mechanism.torque_distribution->shares;
  constexpr auto kind = ValidationIssueKind::torque_distribution;
  if (shares.size() != mechanism.actuators.size())
    return ElementValidator(ElementKind::mechanism, 0, mechanism.name, issues)
        .add(kind, "the torque distribution must have one share for each of the " +
                       std::to_string(mechanism.actuators.size()) + " actuators, has " + std::to_string(shares.size()));
  for (std::size_t a = 0; a < shares.size(); ++a) {
    const EffortShare& share = shares[a];
    ElementValidator faults(ElementKind::actuator, a, "", issues);
    if (faults.check_finite(share.weight, "the weight") && !(share.weight > 0))
      faults.add(kind, "the weight must be positive, is " + format_element(share.weight));
    bool is_finite = true;
    for (const auto& bound : {share.lower, share.upper, share.preload})
      is_finite = (!bound || faults.check_finite(*bound, "the bound of the effort")) && is_finite;
    if (share.preload && *share.preload == 0) faults.add(kind, "the preload must not be zero");
    const std::optional<double> lower = share.lower_bound(), upper = share.upper_bound();
    if (is_finite && lower && upper && *lower > *upper)
      faults.add(kind, "limits and preload contradict each other: the effort would be at least " +
                           format_element(*lower) + " and at most " + format_element(*upper));
  }
}

void check_references(const Mechanism& mechanism, std::vector<ValidationIssue>& issues) {
  std::set<CoordinateId> actuated;
  for (std::size_t a = 0; a < mechanism.actuators.size(); ++a) {
    ElementValidator faults(ElementKind::actuator, a, "", issues);
    if (faults.check_index(mechanism.actuators[a], mechanism.coordinates.size(), "its coordinate") &&
        !actuated.insert(mechanism.actuators[a]).second)
      faults.add(ValidationIssueKind::duplicate_reference, "another actuator drives the same coordinate");
  }
  if (mechanism.tool) {
    ElementValidator faults(ElementKind::tool, 0, "", issues);
    faults.check_index(mechanism.tool->body, mechanism.bodies.size(), "its body");
    faults.check_position(mechanism.tool->position, mechanism.space == SpaceKind::planar, "its position");
  }
  for (std::size_t k = 0; k < mechanism.assembly.size(); ++k) {
    ElementValidator faults(ElementKind::assembly, k, "", issues);
    faults.check_index(mechanism.assembly[k].coordinate, mechanism.coordinates.size(), "its coordinate");
    faults.check_finite(mechanism.assembly[k].value, "the value");
  }
}

}  // namespace

std::vector<ValidationIssue> validate(const Mechanism& mechanism) {
  std::vector<ValidationIssue> issues;
  if (!check_counts(mechanism, issues)) return issues;
  check_bodies(mechanism, issues);
  check_joints(mechanism, issues);
  check_coordinates(mechanism, issues);
  check_connected(mechanism, issues);
  check_couplings(mechanism, issues);
  check_constraints(mechanism, issues);
  check_attachments(mechanism, issues);
  check_discs(mechanism, issues);
  check_loads(mechanism, issues);
  check_springs(mechanism, issues);
  check_force_elements(mechanism, issues);
  check_friction(mechanism, issues);
  check_references(mechanism, issues);
  check_torque_distribution(mechanism, issues);
  return issues;
}

bool has_mass(const Mechanism& mechanism) {
  const auto has_positive_mass = [](const auto& element) { return element.mass > 0; };
  return std::any_of(mechanism.bodies.begin(), mechanism.bodies.end(), has_positive_mass) ||
         std::any_of(mechanism.attachments.begin(), mechanism.attachments.end(), has_positive_mass) ||
         std::any_of(mechanism.discs.begin(), mechanism.discs.end(), has_positive_mass);
}

void require_valid(const Mechanism& mechanism) {
  std::string sentences;
  for (const ValidationIssue& fault : validate(mechanism)) sentences += (sentences.empty() ? "" : "\n") + fault.message;
  if (!sentences.empty()) throw std::invalid_argument(sentences);
}

// Constraints on speeds.
void check_constraints(const Mechanism& mechanism, std::vector<ValidationIssue>& issues) {
  const bool planar = mechanism.space == SpaceKind::planar;
  std::set<std::string> names;
  for (std::size_t k = 0; k < mechanism.constraints.size(); ++k) {
    const GeneralisedSpeed& constraint = mechanism.constraints[k];
    ElementValidator faults(ElementKind::constraint, k, constraint.name, issues);
    if (!constraint.name.empty() && !names.insert(constraint.name).second)
      faults.add(ValidationIssueKind::duplicate_name, "another constraint has the same name");
    if (constraint.terms.empty()) faults.add(ValidationIssueKind::index_out_of_range, "it has no terms");
    for (const GeneralisedSpeedTerm& term : constraint.terms) {
      using enum GeneralisedSpeedTerm::Kind;
      if (faults.check_finite(term.factor, "a factor") && term.factor == 0)
        faults.add(ValidationIssueKind::ratio_zero, "no factor may be zero: leave its term out");
      if (term.kind == com_velocity || term.pose_factor)
        faults.add(ValidationIssueKind::index_out_of_range,
                   "a constraint on speeds cannot contain the velocity of the centre of mass or a factor that depends "
                   "on the pose");
      if (term.kind == coordinate) {
        faults.check_index(term.index, mechanism.coordinates.size(), "a coordinate");
        continue;
      }
      faults.check_index(term.body, mechanism.bodies.size(), "a body");
      faults.check_position(term.position, planar, "a point");
      const bool is_angular = term.kind == angular_velocity || term.kind == angular_velocity_body;
      if (faults.check_index(term.index, 3, "a component") && planar && (term.index == 2) != is_angular)
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

/// Whether this type of joint exists in the plane, or in space.
bool exists_in(JointType type, bool planar) {
  switch (type) {
    case JointType::revolute:
    case JointType::prismatic:
    case JointType::fixed:
    case JointType::planar: return true;
    case JointType::pin_slot: return planar;
    case JointType::cylindrical:
    case JointType::universal:
    case JointType::spherical:
    case JointType::free:
    case JointType::rolling_disc:
    case JointType::rolling_sphere: return !planar;
  }
  return false;
}

void check_axes(const Joint& joint, bool planar, ElementValidator& faults) {
  constexpr double perpendicularity_tolerance = 1e-9;
  const bool is_sliding = joint.type == JointType::prismatic || joint.type == JointType::pin_slot;
  if (joint.type == JointType::fixed || joint.type == JointType::spherical || joint.type == JointType::free) return;
  faults.check_unit_vector(joint.axis, "its axis");
  if (planar && is_sliding && joint.axis.z() != 0)
    faults.add(ValidationIssueKind::out_of_plane, "its axis must lie in the plane of the mechanism");
  if (planar && !is_sliding && joint.axis != Vector3::UnitZ())
    faults.add(ValidationIssueKind::out_of_plane,
               "the axis of a revolute or planar joint must be z, as the mechanism is planar");
  if (joint.type != JointType::universal && joint.type != JointType::planar && !is_rolling(joint.type)) return;
  faults.check_unit_vector(joint.axis2, "its axis2");
  if (planar && joint.axis2.z() != 0)
    faults.add(ValidationIssueKind::out_of_plane, "its axis2 must lie in the plane of the mechanism");
  if (std::abs(joint.axis.dot(joint.axis2)) > perpendicularity_tolerance)
    faults.add(ValidationIssueKind::axes_not_perpendicular,
               "its axes must be perpendicular, their cosine is " + format_element(joint.axis.dot(joint.axis2)));
}

void check_rotation(const Matrix3& R, bool planar, ElementValidator& faults) {
  constexpr double orthogonality_tolerance = 1e-9;
  if (!faults.check_finite(R, "its rotation")) return;
  if (!(numerics::max_abs(R * R.transpose() - Matrix3::Identity()) <= orthogonality_tolerance))
    faults.add(ValidationIssueKind::rotation_not_proper, "its rotation must be an orthogonal matrix");
  else if (R.determinant() < 0)
    faults.add(ValidationIssueKind::rotation_not_proper, "its rotation must not be a reflection");
  else if (planar && !(numerics::max_abs(R.col(2) - Vector3::UnitZ()) <= orthogonality_tolerance))
    faults.add(ValidationIssueKind::out_of_plane, "its rotation must be about z, as the mechanism is planar");
}

std::string format_mass_issue(double mass) { return "the mass must be positive, is " + format_element(mass); }

}  // namespace

bool check_followed(const CoordinateCombination& followed, std::size_t coordinates, const char* what,
                    ElementValidator& faults) {
  bool is_valid = !followed.terms.empty();
  if (!is_valid) faults.add(ValidationIssueKind::index_out_of_range, std::string(what) + " is missing");
  std::set<int> visited;
  for (const CoordinateTerm& term : followed.terms) {
    is_valid = faults.check_index(term.coordinate, coordinates, what) && is_valid;
    if (!visited.insert(term.coordinate).second)
      faults.add(ValidationIssueKind::duplicate_reference, std::string(what) + " is named twice");
    if (faults.check_finite(term.ratio, "the ratio") && term.ratio == 0)
      faults.add(ValidationIssueKind::ratio_zero, "no ratio may be zero: leave its coordinate out");
  }
  return is_valid;
}

void check_bodies(const Mechanism& mechanism, std::vector<ValidationIssue>& issues) {
  const bool planar = is_planar(mechanism);
  std::set<std::string> names;
  for (std::size_t b = 0; b < mechanism.bodies.size(); ++b) {
    const Body& body = mechanism.bodies[b];
    ElementValidator faults(ElementKind::body, b, body.name, issues);
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

void check_joints(const Mechanism& mechanism, std::vector<ValidationIssue>& issues) {
  const bool planar = is_planar(mechanism);
  std::set<std::string> names;
  for (std::size_t j = 0; j < mechanism.joints.size(); ++j) {
    const Joint& joint = mechanism.joints[j];
    ElementValidator faults(ElementKind::joint, j, joint.name, issues);
    if (!names.insert(joint.name).second)
      faults.add(ValidationIssueKind::duplicate_name, "another joint has the same name");
    const bool first = faults.check_index(joint.first, mechanism.bodies.size(), "its first body");
    const bool second = faults.check_index(joint.second, mechanism.bodies.size(), "its second body");
    if (first && second && joint.first == joint.second)
      faults.add(ValidationIssueKind::same_body, "it must connect two different bodies");
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
                 "the rolling radius must be positive, is " + format_element(joint.radius));
  }
}

void check_attachments(const Mechanism& mechanism, std::vector<ValidationIssue>& issues) {
  const bool planar = is_planar(mechanism);
  std::set<std::pair<AttachmentKind, std::string>> names;
  for (std::size_t a = 0; a < mechanism.attachments.size(); ++a) {
    const Attachment& attachment = mechanism.attachments[a];
    ElementValidator faults(ElementKind::attachment, a, attachment.name, issues);
    if (!attachment.name.empty() && !names.emplace(attachment.kind, attachment.name).second)
      faults.add(ValidationIssueKind::duplicate_name, "another attachment has the same name");
    faults.check_index(attachment.body, mechanism.bodies.size(), "its body");
    faults.check_position(attachment.position, planar, "its position");
    if (faults.check_finite(attachment.mass, "the mass") && attachment.mass < 0)
      faults.add(ValidationIssueKind::mass_negative,
                 "the mass must not be negative, is " + format_element(attachment.mass));
    check_inertia(attachment.inertia, planar, InertiaOwner::attachment, faults);
    if (!(attachment.from < attachment.until))
      faults.add(ValidationIssueKind::empty_payload_interval,
                 "it is taken up at " + format_element(attachment.from) + " s and set down at " +
                     format_element(attachment.until) + " s, which must be later");
  }
}

void check_discs(const Mechanism& mechanism, std::vector<ValidationIssue>& issues) {
  const bool planar = is_planar(mechanism);
  std::set<std::string> names;
  for (std::size_t d = 0; d < mechanism.discs.size(); ++d) {
    const Disc& disc = mechanism.discs[d];
    ElementValidator faults(ElementKind::disc, d, disc.name, issues);
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
  const std::size_t entries = load.arguments.empty() ? 1 : load.arguments.size();
  if (load.force.size() != entries || load.moment.size() != entries)
    faults.add(ValidationIssueKind::load_table, "it must have " + std::to_string(entries) +
                                                    " forces and moments, has " + std::to_string(load.force.size()) +
                                                    " and " + std::to_string(load.moment.size()));
  for (const double argument : load.arguments)
    if (!faults.check_finite(argument, "an argument of its table")) return;
  for (std::size_t k = 1; k < load.arguments.size(); ++k)
    if (!(load.arguments[k] > load.arguments[k - 1]))
      return faults.add(ValidationIssueKind::load_table, "the arguments of its table must increase, " +
                                                             format_element(load.arguments[k]) + " follows " +
                                                             format_element(load.arguments[k - 1]));
  const std::size_t distinct = entries - (load.is_periodic ? 1 : 0);
  if (load.is_periodic &&
      (entries < 2 || load.force.front() != load.force.back() || load.moment.front() != load.moment.back()))
    faults.add(ValidationIssueKind::load_table, "a periodic table must end as it starts");
  if (load.is_periodic && load.is_spline && distinct < 3)
    faults.add(ValidationIssueKind::load_table, "a closed spline needs three different entries");
  for (const Vector3& force : load.force) faults.check_position(force, planar, "a force");
  for (const Vector3& moment : load.moment)
    if (faults.check_finite(moment, "a moment") && planar && !moment.head<2>().isZero(0))
      faults.add(ValidationIssueKind::out_of_plane, "a moment of a planar mechanism must lie along z");
}

}  // namespace

void check_loads(const Mechanism& mechanism, std::vector<ValidationIssue>& issues) {
  const bool planar = is_planar(mechanism);
  std::set<std::string> names;
  for (std::size_t k = 0; k < mechanism.loads.size(); ++k) {
    const Load& load = mechanism.loads[k];
    ElementValidator faults(ElementKind::load, k, load.name, issues);
    if (!load.name.empty() && !names.insert(load.name).second)
      faults.add(ValidationIssueKind::duplicate_name, "another load has the same name");
    faults.check_index(load.body, mechanism.bodies.size(), "its body");
    faults.check_position(load.point, planar, "its point");
    if (load.frame != Frame::world && load.frame != Frame::body)
      faults.add(ValidationIssueKind::unknown_value, "its frame must be the world's or the body's");
    if (load.is_over_coordinate()) faults.check_index(load.coordinate, mechanism.coordinates.size(), "its coordinate");
    if (load.is_over_coordinate() && load.arguments.empty())
      faults.add(ValidationIssueKind::load_table, "it depends on a coordinate, but has no table");
    check_table(load, planar, faults);
  }
}

namespace {

/// Of a spring or a damper between points.
template <class Element>
void check_ends(const Element& element, const Mechanism& mechanism, ElementValidator& faults) {
  const bool planar = is_planar(mechanism);
  const bool first = faults.check_index(element.first, mechanism.bodies.size(), "its first body");
  const bool second = faults.check_index(element.second, mechanism.bodies.size(), "its second body");
  if (first && second && element.first == element.second)
    faults.add(ValidationIssueKind::same_body, "it must act between two different bodies");
  faults.check_position(element.point_first, planar, "its point on the first body");
  faults.check_position(element.point_second, planar, "its point on the second body");
}

}  // namespace

void check_springs(const Mechanism& mechanism, std::vector<ValidationIssue>& issues) {
  std::set<std::string> names;
  for (std::size_t k = 0; k < mechanism.springs.size(); ++k) {
    const Spring& spring = mechanism.springs[k];
    ElementValidator faults(ElementKind::spring, k, spring.name, issues);
    if (!spring.name.empty() && !names.insert(spring.name).second)
      faults.add(ValidationIssueKind::duplicate_name, "another spring has the same name");
    faults.check_not_negative(spring.stiffness, "the stiffness");
    if (spring.is_joint_spring()) {
      faults.check_index(spring.coordinate, mechanism.coordinates.size(), "its coordinate");
      faults.check_finite(spring.preload, "the preload");
      continue;
    }
    check_ends(spring, mechanism, faults);
    if (!spring.slack_length)
      faults.check_not_negative(spring.free_length, "the free length");
    else if (faults.check_finite(spring.free_length, "the free length"))
      faults.check_not_negative(*spring.slack_length, "the length at which it is slack");
    for (const std::optional<double>& end : {spring.shortest_length, spring.longest_length})
      if (end) faults.check_not_negative(*end, "an end of the travel");
  }
}

namespace {

void check_force_table(const model::ForceTableOf<double>& table, ElementValidator& faults) {
  const std::size_t rows = table.force.size(), min_rows = table.interpolation == TableInterpolation::spline ? 4 : 2;
  if (table.displacement.size() != rows || rows < min_rows)
    return faults.add(ValidationIssueKind::force_table, "its table must have at least " + std::to_string(min_rows) +
                                                            " displacements and as many forces, has " +
                                                            std::to_string(table.displacement.size()) + " and " +
                                                            std::to_string(rows));
  for (std::size_t k = 0; k < rows; ++k)
    if (!faults.check_finite(table.displacement[k], "a displacement") ||
        !faults.check_finite(table.force[k], "a force"))
      return;
  for (std::size_t k = 1; k < rows; ++k)
    if (!(table.displacement[k] > table.displacement[k - 1]))
      return faults.add(ValidationIssueKind::force_table, "its displacements must increase, " +
                                                              format_element(table.displacement[k]) + " follows " +
                                                              format_element(table.displacement[k - 1]));
}

}  // namespace

void check_force_elements(const Mechanism& mechanism, std::vector<ValidationIssue>& issues) {
  for (std::size_t k = 0; k < mechanism.force_elements.size(); ++k) {
    const ForceElement& element = mechanism.force_elements[k];
    ElementValidator faults(ElementKind::force_element, k, element.name, issues);
    if (!element.is_damper()) check_force_table(element.table, faults);
    if (element.is_in_joint()) {
      faults.check_index(element.coordinate, mechanism.coordinates.size(), "its coordinate");
      if (element.is_damper())
        faults.add(ValidationIssueKind::force_table, "a damper in a joint is viscous friction of its coordinate");
      continue;
    }
    check_ends(element, mechanism, faults);
    faults.check_not_negative(element.damping, "the damping");
  }
}

void check_friction(const Mechanism& mechanism, std::vector<ValidationIssue>& issues) {
  std::set<int> coordinates_with_friction;
  for (std::size_t k = 0; k < mechanism.friction.size(); ++k) {
    const Friction& friction = mechanism.friction[k];
    ElementValidator faults(ElementKind::friction, k, "", issues);
    if (faults.check_index(friction.coordinate, mechanism.coordinates.size(), "its coordinate") &&
        !coordinates_with_friction.insert(friction.coordinate).second)
      faults.add(ValidationIssueKind::duplicate_reference, "its coordinate already has friction");
    faults.check_not_negative(friction.viscous, "the viscous friction");
    faults.check_not_negative(friction.coulomb, "the dry friction");
    if (friction.coulomb_backward) faults.check_not_negative(*friction.coulomb_backward, "the backward dry friction");
    bool finite = true;
    for (const std::optional<double>& limit : {friction.breakaway, friction.at_rest_backward})
      if (limit) finite = faults.check_finite(*limit, "the static friction") && finite;
    if (finite &&
        (friction.static_limit(1) < friction.dry_friction(1) || friction.static_limit(-1) < friction.dry_friction(-1)))
      faults.add(ValidationIssueKind::breakaway_below_coulomb,
                 "the static friction must not be less than the dry friction");
  }
}

}  // namespace balance::model
