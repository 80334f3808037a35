#pragma once
/// Eccentric discs, such as balance shafts: a mass on a massless shaft, a body with a revolute joint and a coupling. Mass,
/// body and joint have the disc's name.

#include "balance/mechanics/model/mechanism.hpp"

#include <algorithm>

namespace balance::model {

/// Whether a mass is that of an eccentric disc.
template <class T>
bool is_eccentric_disc(const MechanismOf<T>& mechanism, const AttachmentOf<T>& mass) {
  return mass.kind == AttachmentKind::counterweight && mass.body >= 0 &&
         mechanism.bodies[static_cast<std::size_t>(mass.body)].name == mass.name &&
         std::any_of(mechanism.joints.begin(), mechanism.joints.end(),
                     [&](const auto& joint) { return joint.name == mass.name && joint.second == mass.body; });
}

/// Replaces the place of an eccentric disc and its ratio by numbers that depend on nothing.
template <class T>
void make_shaft_constant(MechanismOf<T>& mechanism, const AttachmentOf<T>& mass) {
  for (auto& joint : mechanism.joints)
    if (joint.second == mass.body) joint.point_first = Vector3Of<T>::Zero();
  for (auto& coupling : mechanism.couplings) {
    const auto joint =
        static_cast<std::size_t>(mechanism.coordinates[static_cast<std::size_t>(coupling.follower)].joint);
    if (mechanism.joints[joint].second == mass.body) coupling.ratio = T(1);
  }
}

}  // namespace balance::model
