#pragma once
/// Whether a mechanism that somebody put together by hand is one: every algorithm of the library relies on what is checked here.

#include "balance/foundation/base/types.hpp"
#include "balance/mechanics/model/mechanism.hpp"

#include <string>
#include <vector>

namespace balance {

// Which masses and inertias a body can have: the one rule of validate() and of the spec's reader.

/// Who bears an inertia. That of a body is positive definite or, of a point mass, zero; that of what is added to one may have zero
/// principal moments.
enum class InertiaOwner { body, attachment };

enum class InertiaIssue {
  none,
  not_positive_definite,  ///< a principal moment is negative, or zero beside others that are not
  triangle_violated,      ///< a principal moment above the sum of the other two
};

struct InertiaCheck {
  InertiaIssue issue = InertiaIssue::none;
  Vector3 principal_moments = Vector3::Zero();  ///< increasing; planar: the zz entry last
};

/// @param inertia about the centre of mass, symmetric; principal moments may be off by 1e-6 of the largest
InertiaCheck find_inertia_issue(const Matrix3& inertia, bool planar, InertiaOwner bearer);

/// A body without mass is one without inertia.
inline bool is_valid_mass(double mass, const Matrix3& inertia) { return mass > 0 || (mass == 0 && inertia.isZero(0)); }

/// What is wrong. Comments say which numbers are meant where that is not plain.
enum class ValidationIssueKind {
  unknown_value,          ///< an enumeration holds a value that it does not have
  no_ground,              ///< there are no bodies at all
  no_moving_body,         ///< bodies[0] is alone
  ground_with_mass,       ///< bodies[0] has mass or inertia
  not_finite,             ///< a number is infinite or none
  index_out_of_range,     ///< of a body, joint or coordinate
  mass_not_positive,      ///< of a moving body: negative, or zero with an inertia that is not
  mass_negative,          ///< of an attachment or a disc
  inertia_not_symmetric,  ///< in space
  inertia_not_positive,  ///< body: neither positive definite nor zero; else a negative principal moment; planar: its zz entry
  inertia_triangle_violated,  ///< a principal moment above the sum of the other two
  axis_not_unit,
  axes_not_perpendicular,    ///< axis and axis2 of a universal or planar joint are not at a right angle
  rotation_not_proper,       ///< not orthogonal, or a reflection
  joint_type_not_in_space,   ///< does not exist in this space
  same_body,                 ///< a joint or spring between a body and itself
  coordinates_inconsistent,  ///< not list_coordinates(space, joints)
  not_connected,             ///< no chain of joints from the ground to a body
  duplicate_follower,        ///< a coordinate follows two others
  coupling_cycle,            ///< a coordinate follows itself
  ratio_zero,                ///< of a coupling, a disc or a term of a constraint
  duplicate_name,  ///< two bodies, two joints, two points of a body, …; only elements other than bodies and joints may be nameless
  duplicate_reference,      ///< a coordinate is actuated twice or has friction twice
  empty_payload_interval,   ///< an attachment that is set down before it is taken up, or at a time that is no number
  load_table,               ///< times do not increase, or forces and moments are not as many as times
  negative_number,          ///< stiffness, free length, friction, or a radius that is not positive
  breakaway_below_coulomb,  ///< less than the friction of sliding
  out_of_plane,             ///< a planar mechanism has numbers that leave its plane
};

/// Which list of the mechanism an element is in.
enum class ElementKind {
  mechanism,  ///< no list: index 0
  body,
  joint,
  coordinate,
  coupling,
  constraint,
  attachment,
  disc,
  load,
  spring,
  friction,
  actuator,
  tool,  ///< no list: index 0
  assembly,
};

struct ValidationIssue {
  ValidationIssueKind kind = ValidationIssueKind::not_finite;
  ElementKind element = ElementKind::mechanism;
  int index = 0;        ///< in the element's list
  std::string message;  ///< "body 'crank': the mass must be positive, is -1"
};

/// Every fault of a mechanism, in the order of its lists. Mechanisms that the spec's reader returns have none. What cannot be said
/// because of another fault (a circle of couplings whose coordinates do not exist) is left out.
/// Unit vectors, right angles and rotations may be off by 1e-9, principal moments by 1e-6 of the largest.
std::vector<ValidationIssue> validate(const Mechanism& mechanism);

/// A body, an attachment or a disc has some.
bool has_mass(const Mechanism& mechanism);

/// Why nothing can be computed that is divided by a mass.
inline constexpr const char* no_mass_message =
    "no body has mass: there is no centre of mass, and no force or effort to find";

/// @throws std::invalid_argument if there are faults, with all their sentences, one a line
void require_valid(const Mechanism& mechanism);

}  // namespace balance
