#pragma once
/// Validation of mechanisms that were built in code. Every algorithm of the library relies on what is checked here.

#include "balance/foundation/base/types.hpp"
#include "balance/mechanics/model/mechanism.hpp"

#include <string>
#include <vector>

namespace balance::model {

// Which masses and inertias a body can have; shared by validate() and the spec reader.

/// Owner of an inertia. A body's inertia is positive definite or, for a point mass, zero. An attachment's inertia may
/// have zero principal moments.
enum class InertiaOwner { body, attachment };

enum class InertiaIssue {
  none,
  not_positive_definite,  ///< a principal moment is negative, or zero while others are not
  triangle_violated,      ///< a principal moment exceeds the sum of the other two
};

struct InertiaCheck {
  InertiaIssue issue = InertiaIssue::none;
  Vector3 principal_moments = Vector3::Zero();  ///< in increasing order; planar: the zz entry, in the last place
};

/// @param inertia about the centre of mass, symmetric; principal moments may be off by 1e-6 of the largest
InertiaCheck find_inertia_issue(const Matrix3& inertia, bool planar, InertiaOwner owner);

/// A body without mass must have no inertia.
inline bool is_valid_mass(double mass, const Matrix3& inertia) { return mass > 0 || (mass == 0 && inertia.isZero(0)); }

/// Kinds of faults. Comments state the numbers concerned where the name does not.
enum class ValidationIssueKind {
  unknown_value,          ///< an enumeration holds an undefined value
  no_ground,              ///< there are no bodies
  no_moving_body,         ///< bodies[0] is the only body
  ground_with_mass,       ///< bodies[0] has mass or inertia
  not_finite,             ///< a number is infinite or NaN
  index_out_of_range,     ///< of a body, joint or coordinate
  mass_not_positive,      ///< of a moving body: negative, or zero with a nonzero inertia
  mass_negative,          ///< of an attachment or a disc
  inertia_not_symmetric,  ///< spatial mechanisms
  inertia_not_positive,   ///< body: not positive definite, not zero; others: a negative principal moment; planar: zz
  inertia_triangle_violated,  ///< a principal moment exceeds the sum of the other two
  axis_not_unit,
  axes_not_perpendicular,    ///< axis and axis2 of a universal, planar or rolling joint are not perpendicular
  rotation_not_proper,       ///< not orthogonal, or a reflection
  joint_type_not_in_space,   ///< this joint type does not exist in this space
  same_body,                 ///< a joint or spring between a body and itself
  coordinates_inconsistent,  ///< differ from list_coordinates(space, joints)
  not_connected,             ///< no chain of joints from the ground to the body
  duplicate_follower,        ///< a coordinate follows two leaders
  coupling_cycle,            ///< a coordinate follows itself
  ratio_zero,                ///< of a coupling, a disc or a term of a constraint
  duplicate_name,            ///< two bodies, two joints, two points of a body, …; only bodies and joints need names
  duplicate_reference,       ///< a coordinate is actuated twice, has friction twice, or occurs twice in a combination
  empty_payload_interval,    ///< an attachment is not set down after it is taken up
  load_table,                ///< times do not increase, or the numbers of forces, moments and times differ
  force_table,               ///< displacements do not increase, too few rows, or the numbers of both differ
  negative_number,           ///< stiffness, free length, friction, or a radius that is not positive
  breakaway_below_coulomb,   ///< static friction below sliding friction
  out_of_plane,              ///< numbers of a planar mechanism are not in its plane
  torque_distribution,       ///< not one share per actuator, a weight that is not positive, or bounds that contradict
};

/// The list of the mechanism that an element belongs to.
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
  force_element,
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

/// Returns every fault of a mechanism, in the order of its lists. The spec reader returns only mechanisms without
/// faults. Checks that depend on a faulty element (a cycle of couplings whose coordinates do not exist) are skipped.
/// Tolerances: 1e-9 for unit vectors, right angles and rotations; 1e-6 of the largest for principal moments.
std::vector<ValidationIssue> validate(const Mechanism& mechanism);

/// Whether a body, an attachment or a disc has mass.
bool has_mass(const Mechanism& mechanism);

/// Reason why quantities divided by a mass cannot be computed.
inline constexpr const char* no_mass_message =
    "no body has mass: there is no centre of mass, and no force or effort to compute";

/// @throws std::invalid_argument if there are faults; what() holds all messages, one per line
void require_valid(const Mechanism& mechanism);

}  // namespace balance::model

namespace balance {

using model::validate;
using model::ValidationIssue;

}  // namespace balance
