#pragma once
/// Which parts of a mechanism belong to which.

#include "balance/model/mechanism.hpp"

#include <vector>

namespace balance {

/// Per body its joints, in their order.
std::vector<std::vector<JointId>> joints_of_bodies(const Mechanism& mechanism);

/// Per joint its coordinates, in their order.
std::vector<std::vector<CoordinateId>> coordinates_of_joints(const Mechanism& mechanism);

}  // namespace balance
