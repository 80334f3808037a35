#pragma once
/// Inertias and whether a body can have them.

#include "balance/model/inertia_rule.hpp"
#include "balance/spec/draft.hpp"

namespace balance::specification {

/// A number (planar), three or six numbers [Ixx, Iyy, Izz, Ixy, Ixz, Iyz] (spatial): the entries of the matrix, Ixy = −∫xy dm.
Matrix3E read_inertia_value(const SpecCursor& at, StudyBuilder& draft);

/// A body's: the same, `{about: origin, value: …}`, or `{as_given: …}`, which keeps what no body can have and warns of it.
/// @return about the CoM; checked with check_inertia
/// @param mass nothing if mass or com could not be read: then nothing is moved
Matrix3E read_inertia(const SpecCursor& at, StudyBuilder& draft, const std::optional<Expression>& mass,
                      const Vector3E& com);

/// Fails unless the inertia about the CoM belongs to some distribution of positive mass.
void check_inertia(const SpecCursor& at, const Matrix3E& inertia, const StudyBuilder& draft, InertiaOwner bearer);

}  // namespace balance::specification
