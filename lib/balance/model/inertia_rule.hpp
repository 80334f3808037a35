#pragma once
/// Which masses and inertias a body can have: the one rule of validate() and of the spec's reader.

#include "balance/base/types.hpp"

namespace balance {

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

}  // namespace balance
