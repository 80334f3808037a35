#pragma once
/// Where a study's mechanism starts from: the configuration that its conditions hold around.

#include "balance/study/study.hpp"

#include <vector>

namespace balance {

/// All coordinates at the start of the first trajectory, in the assembly mode that the spec picks; empty without trajectories or
/// if the pose cannot be reached.
std::vector<CoordinateValue> start_coordinates(const Study& study);

/// The mechanism, to be assembled where these coordinates say; as it is if there are none.
Mechanism assembled_at(Mechanism mechanism, const std::vector<CoordinateValue>& coordinates);

}  // namespace balance
