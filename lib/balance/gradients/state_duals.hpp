#pragma once
/// One state's derivatives by numbers that the mechanism's own depend on.

#include "balance/gradients/over_duals.hpp"
#include "balance/gradients/state_gradient.hpp"

namespace balance {

/// As derivatives() by numbers of the mechanism.
/// @param mechanism over duals, with the values of the door's mechanism @return dual_width derivatives
Expected<StateGradient> derivatives(InverseDynamics& door, const MechanismOf<DualNumber>& mechanism, const VectorX& q,
                                    const VectorX& dq, const VectorX& ddq, double time = 0);

}  // namespace balance
